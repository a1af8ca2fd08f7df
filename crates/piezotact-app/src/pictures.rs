//! Figures as PNG and PDF, with their fonts.

use std::sync::Arc;

use anyhow::{Context as _, Result, anyhow};
use svg2pdf::usvg::fontdb::{Database, Family, Query};
use svg2pdf::usvg::{Options, Tree};

/// Fonts without serifs, in the order in which they are looked for.
const FONTS: [&str; 6] = [
    "DejaVu Sans",
    "Liberation Sans",
    "Noto Sans",
    "Arial",
    "Helvetica",
    "Helvetica Neue",
];
/// The resolution of a PNG, dots per inch.
const DPI: f32 = 300.0;

/// What draws figures with the fonts of this system.
pub(crate) struct Pictures {
    options: Options<'static>,
}

impl Pictures {
    /// The fonts of this system.
    ///
    /// # Errors
    /// Where none of the known fonts is installed: a figure would have no text.
    pub(crate) fn new() -> Result<Self> {
        let mut fonts = Database::new();
        fonts.load_system_fonts();
        let is_there = |name: &&&str| {
            let families = [Family::Name(name)];
            let query = Query {
                families: &families,
                ..Query::default()
            };
            fonts.query(&query).is_some()
        };
        let found = FONTS.iter().find(is_there).ok_or_else(|| {
            anyhow!(
                "PNG and PDF need a font, and none of {} is installed; install one, such as the package fonts-dejavu-core",
                FONTS.join(", ")
            )
        })?;
        fonts.set_sans_serif_family(*found);
        Ok(Self {
            options: Options {
                dpi: 96.0,
                font_family: (*found).to_owned(),
                fontdb: Arc::new(fonts),
                ..Options::default()
            },
        })
    }

    /// The figure `svg` as PDF, with the fonts that it uses.
    ///
    /// # Errors
    /// Where it is no SVG.
    pub(crate) fn pdf(&self, svg: &str) -> Result<Vec<u8>> {
        let tree = Tree::from_str(svg, &self.options).context("a figure is not SVG")?;
        // The size of the figure in points: 72 of them are an inch, as 96 pixels are.
        let page = svg2pdf::PageOptions { dpi: 96.0 };
        svg2pdf::to_pdf(&tree, svg2pdf::ConversionOptions::default(), page)
            .map_err(|error| anyhow!("a figure cannot be drawn as PDF: {error}"))
    }

    /// The figure `svg` as PNG of 300 dots per inch.
    ///
    /// # Errors
    /// Where it is no SVG, or has no area.
    pub(crate) fn png(&self, svg: &str) -> Result<Vec<u8>> {
        let tree = Tree::from_str(svg, &self.options).context("a figure is not SVG")?;
        let scale = DPI / 96.0;
        let size = tree.size().to_int_size().scale_by(scale);
        let size = size.context("a figure has no area")?;
        let mut pixels = resvg::tiny_skia::Pixmap::new(size.width(), size.height())
            .context("a figure is too large for PNG")?;
        let transform = resvg::tiny_skia::Transform::from_scale(scale, scale);
        resvg::render(&tree, transform, &mut pixels.as_mut());
        Ok(pixels.encode_png()?)
    }
}
