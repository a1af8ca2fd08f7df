//! A command that is called as a function, on the thread that calls it: data that are given instead of files, and what the command
//! would print, kept.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use piezotact::page::Page;
use piezotact_dataset::Contents;
use serde_json::Value;

use crate::invocation::Called;

thread_local! {
    static CALL: RefCell<Option<Call>> = const { RefCell::new(None) };
}

/// What a command that is called as a function has, and leaves.
#[derive(Default)]
pub(crate) struct Call {
    /// Recordings by the names that the words of the command have for them.
    pub(crate) given: BTreeMap<PathBuf, Arc<Contents>>,
    /// How it was called.
    pub(crate) called: Option<Arc<Called>>,
    /// The document that it would print.
    pub(crate) document: Option<Value>,
    /// The report of its result.
    pub(crate) page: Option<Page>,
    /// Other lines that it would print.
    pub(crate) printed: Vec<String>,
    /// Lines that it would say on standard error.
    pub(crate) said: Vec<String>,
}

/// Does `work` as the `call`, and gives back what it left.
pub(crate) fn within<T>(call: Call, work: impl FnOnce() -> T) -> (T, Call) {
    CALL.set(Some(call));
    let done = work();
    (done, CALL.take().unwrap_or_default())
}

/// What `then` does with the call of this thread; `None` in the program.
pub(crate) fn with<T>(then: impl FnOnce(&mut Call) -> T) -> Option<T> {
    CALL.with_borrow_mut(|call| call.as_mut().map(then))
}

/// Keeps the document that a command would print; in the program, gives it back.
pub(crate) fn keep_document(document: Value) -> Option<Value> {
    let mut document = Some(document);
    with(|call| call.document = document.take());
    document
}

/// Keeps the report of a result; in the program, gives it back.
pub(crate) fn keep_page(page: Page) -> Option<Page> {
    let mut page = Some(page);
    with(|call| call.page = page.take());
    page
}

/// Whether data are given that are in no file, so that nobody could run the command again.
pub(crate) fn has_data() -> bool {
    with(|call| !call.given.is_empty()).unwrap_or(false)
}

/// The recording that is given by the name `path`.
pub(crate) fn given(path: &Path) -> Option<Contents> {
    with(|call| call.given.get(path).map(Arc::clone))
        .flatten()
        .map(|contents| Contents::clone(&contents))
}

/// Whether a recording is given by the name `path`.
pub(crate) fn is_given(path: &Path) -> bool {
    with(|call| call.given.contains_key(path)).unwrap_or(false)
}
