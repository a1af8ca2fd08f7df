//! Every test of topographies and roughness, in one program: it is linked once and runs on all cores.

mod lines;
mod roughness;
mod roughness_of_anything;
#[path = "../../piezotact/tests/shared_data/mod.rs"]
mod shared_data;
mod support;
mod texture;
mod topography;
mod topography_array;
mod topography_formats;
mod topography_text;
