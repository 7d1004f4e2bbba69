//! Plots of a set of kicks, drawn when a page requests one.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use axum::extract::State;
use axum::http::header::{CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, X_CONTENT_TYPE_OPTIONS};
use axum::http::{HeaderMap, StatusCode, Uri};
use axum::response::{IntoResponse, Response};

use super::Shared;
use super::guard::check;

/// `/kicks/NAME.svg`. What it shows is the visitor's own, so beyond this machine it takes the token like the scene.
pub(super) async fn picture(State(shared): State<Arc<Shared>>, headers: HeaderMap, uri: Uri) -> Response {
    if let Err(refusal) = check(&headers, &uri, shared.address, shared.token.as_deref()) {
        shared.counts.refused.fetch_add(1, Ordering::Relaxed);
        return (StatusCode::FORBIDDEN, refusal.words()).into_response();
    }
    let name = uri.path().trim_start_matches("/kicks/").strip_suffix(".svg").map(str::to_owned);
    let drawn = match (name, shared.pictures.clone()) {
        // Frames continue in the meantime.
        (Some(name), Some(draw)) => tokio::task::spawn_blocking(move || draw(&name)).await.ok().flatten(),
        _ => None,
    };
    let Some(svg) = drawn else { return (StatusCode::NOT_FOUND, "no such plot").into_response() };
    let headers = [
        (CONTENT_TYPE, "image/svg+xml"),
        // A name of a clip is text, whatever it looks like.
        (CONTENT_SECURITY_POLICY, "default-src 'none'"),
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (CACHE_CONTROL, "no-store"),
    ];
    (headers, svg).into_response()
}
