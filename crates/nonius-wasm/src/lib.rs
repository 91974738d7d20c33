//! Any command of nonius on files in memory, over two integers: a question and its answer are lists of parts, each
//! with its length (four bytes, the lowest first) before it.
//!
//! ```text
//!   question   words of the command, a zero byte between, then name and bytes of each file; no words: the keys of a job (JSON)
//!   answer     JSON (status, standard error, problems), standard output, then name and bytes of each file that is there
//! ```

use nonius::cli::Answer;
use nonius::text::Key;
use nonius::visit::files::Memory;
use serde_json::{Value, json};

/// Room for a question of so many bytes.
#[unsafe(no_mangle)]
pub extern "C" fn room(length: usize) -> *mut u8 {
    Box::leak(vec![0; length].into_boxed_slice()).as_mut_ptr()
}

/// Runs the command of a question; the answer begins with its own length.
///
/// # Safety
/// `start` and `length` are those of [`room`], which is given back.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn run(start: *mut u8, length: usize) -> *mut u8 {
    // SAFETY: the caller hands over what `room` gave.
    let question = unsafe { Box::from_raw(std::ptr::slice_from_raw_parts_mut(start, length)) };
    let mut all = Vec::new();
    add(&mut all, &answered(&question));
    Box::leak(all.into_boxed_slice()).as_mut_ptr()
}

/// Gives the memory of an answer back; `length` as it begins with, and four.
///
/// # Safety
/// `start` is what [`run`] returned.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn forget(start: *mut u8, length: usize) {
    // SAFETY: the caller hands over what `run` gave.
    drop(unsafe { Box::from_raw(std::ptr::slice_from_raw_parts_mut(start, length)) });
}

/// The answer to a question.
fn answered(question: &[u8]) -> Vec<u8> {
    let mut parts = parts(question);
    let words = String::from_utf8_lossy(parts.next().unwrap_or_default());
    let mut files = Vec::new();
    while let Some(file) = parts.next().zip(parts.next()) {
        files.push((String::from_utf8_lossy(file.0).into_owned(), file.1));
    }
    let memory = Memory::of(files.iter().map(|(name, bytes)| (name.as_str(), *bytes)));
    let answer = match words.is_empty() {
        true => Answer { out: keys().into_bytes(), ..Answer::default() },
        false => nonius::cli::answer(&memory, words.split('\0')),
    };
    let told = json!({"status": answer.status, "err": answer.err, "told": answer.problems});
    let mut all = Vec::new();
    add(&mut all, told.to_string().as_bytes());
    add(&mut all, &answer.out);
    for (name, bytes) in memory.all() {
        add(&mut all, name.as_bytes());
        add(&mut all, &bytes);
    }
    all
}

/// Every key that a job may hold: section, words, type.
fn keys() -> String {
    let key = |(section, key): (&str, Key)| json!({"section": section, "key": key.name, "words": key.words, "type": key.of});
    Value::from_iter(nonius::inputs::job::keys().map(key)).to_string()
}

fn add(all: &mut Vec<u8>, part: &[u8]) {
    let length = u32::try_from(part.len()).unwrap_or(u32::MAX);
    all.extend(length.to_le_bytes());
    all.extend(part);
}

/// The parts of a question.
fn parts(mut all: &[u8]) -> impl Iterator<Item = &[u8]> {
    std::iter::from_fn(move || {
        let (length, rest) = all.split_first_chunk()?;
        let (part, rest) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
        all = rest;
        Some(part)
    })
}
