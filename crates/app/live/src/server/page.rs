//! The page's files. They are part of the program.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use axum::extract::State;
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS,
    X_FRAME_OPTIONS,
};
use axum::http::{HeaderMap, StatusCode, Uri};
use axum::response::{IntoResponse, Response};

use super::Shared;
use super::guard::check_host;

const HTML: &str = "text/html; charset=utf-8";
const JS: &str = "text/javascript; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const GLSL: &str = "text/plain; charset=utf-8";

macro_rules! files {
    ($($path:literal, $kind:ident, $file:literal;)+) => {
        /// Path, kind, content.
        const FILES: &[(&str, &str, &str)] =
            &[$(($path, $kind, include_str!(concat!("../../page/", $file)))),+];
    };
}

files! {
    "/", HTML, "index.html";
    "/style.css", CSS, "style.css";
    "/main.js", JS, "main.js";
    "/wire.js", JS, "wire.js";
    "/math.js", JS, "math.js";
    "/mesh.js", JS, "mesh.js";
    "/view.js", JS, "view.js";
    "/hand.js", JS, "hand.js";
    "/panel.js", JS, "panel.js";
    "/course.js", JS, "course.js";
    "/curves.js", JS, "curves.js";
    "/kicks.js", JS, "kicks.js";
    "/solid.vert.glsl", GLSL, "solid.vert.glsl";
    "/solid.frag.glsl", GLSL, "solid.frag.glsl";
    "/ground.vert.glsl", GLSL, "ground.vert.glsl";
    "/ground.frag.glsl", GLSL, "ground.frag.glsl";
    "/net.vert.glsl", GLSL, "net.vert.glsl";
    "/net.frag.glsl", GLSL, "net.frag.glsl";
    "/sky.vert.glsl", GLSL, "sky.vert.glsl";
    "/sky.frag.glsl", GLSL, "sky.frag.glsl";
    "/light.glsl", GLSL, "light.glsl";
}

/// Nothing from elsewhere is loaded or run, no other page may frame this one, and it connects only to its own WebSocket.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; \
     frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

/// A file of the page.
pub(super) async fn file(State(shared): State<Arc<Shared>>, headers: HeaderMap, uri: Uri) -> Response {
    if let Err(refusal) = check_host(&headers, shared.address) {
        shared.counts.refused.fetch_add(1, Ordering::Relaxed);
        return (StatusCode::FORBIDDEN, refusal.words()).into_response();
    }
    let path = if uri.path() == "/index.html" { "/" } else { uri.path() };
    let Some((_, kind, content)) = FILES.iter().find(|(name, ..)| *name == path) else {
        return (StatusCode::NOT_FOUND, "no such file").into_response();
    };
    let headers = [
        (CONTENT_TYPE, *kind),
        (CONTENT_SECURITY_POLICY, POLICY),
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (X_FRAME_OPTIONS, "DENY"),
        (REFERRER_POLICY, "no-referrer"),
        // Another build's page must not meet this program.
        (CACHE_CONTROL, "no-store"),
    ];
    (headers, *content).into_response()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_is_under_300_kilobytes_and_loads_nothing_from_elsewhere() {
        let bytes: usize = FILES.iter().map(|(_, _, content)| content.len()).sum();
        assert!(bytes < 300_000, "{bytes} bytes");
        for (path, _, content) in FILES {
            assert!(!content.contains("https://") && !content.contains("//cdn"), "{path}");
        }
    }

    #[test]
    fn every_file_that_the_page_names_is_served() {
        let quoted = |text: &str| {
            let parts: Vec<String> = text.split(['"', '\'', '`']).map(str::to_owned).collect();
            parts.into_iter().filter(|p| p.starts_with("./")).collect::<Vec<_>>()
        };
        let named: Vec<String> = FILES.iter().flat_map(|(_, _, content)| quoted(content)).collect();
        assert!(named.len() >= FILES.len() - 1, "{named:?}");
        for name in named {
            assert!(FILES.iter().any(|(path, ..)| *path == &name[1..]), "{name}");
        }
    }
}
