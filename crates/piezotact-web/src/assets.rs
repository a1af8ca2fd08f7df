//! Scripts and styles of the pages: our own, and uPlot 1.6.32 (MIT, Leon Sorokin), which draws live traces.

use axum::http::header::CONTENT_TYPE;
use axum::response::IntoResponse;

type File = ([(axum::http::HeaderName, &'static str); 1], &'static [u8]);

fn of_script(bytes: &'static [u8]) -> File {
    ([(CONTENT_TYPE, "text/javascript; charset=utf-8")], bytes)
}

fn of_style(bytes: &'static [u8]) -> File {
    ([(CONTENT_TYPE, "text/css; charset=utf-8")], bytes)
}

pub(crate) async fn script() -> impl IntoResponse {
    of_script(include_bytes!("assets/session.js"))
}

pub(crate) async fn style() -> impl IntoResponse {
    of_style(include_bytes!("assets/session.css"))
}

pub(crate) async fn console_script() -> impl IntoResponse {
    of_script(include_bytes!("assets/console.js"))
}

pub(crate) async fn live_script() -> impl IntoResponse {
    of_script(include_bytes!("assets/live.js"))
}

pub(crate) async fn plot_script() -> impl IntoResponse {
    of_script(include_bytes!("assets/uplot.js"))
}

pub(crate) async fn plot_style() -> impl IntoResponse {
    of_style(include_bytes!("assets/uplot.css"))
}
