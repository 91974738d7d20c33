//! Paths in commands that a user copies into a shell.

use std::path::Path;

/// A path as one word of a command: quoted where the shell of this computer needs it.
pub(super) fn shell_word(path: &Path) -> String {
    let word = path.display().to_string();
    match cfg!(windows) {
        true => cmd_word(&word),
        false => posix_word(&word),
    }
}

/// Letters of file names that no shell reads as anything else.
fn is_plain(c: char) -> bool {
    c.is_alphanumeric() || "_-./:+@".contains(c)
}

/// Double quotes where they are enough, so that a blank looks the same everywhere; else single ones.
fn posix_word(word: &str) -> String {
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_string()
    } else if word.contains(['"', '$', '`', '\\', '!']) {
        format!("'{}'", word.replace('\'', r"'\''"))
    } else {
        format!("\"{word}\"")
    }
}

/// A name of Windows holds no `"`; a backslash before the closing mark would take it away.
fn cmd_word(word: &str) -> String {
    if !word.is_empty() && word.chars().all(|c| is_plain(c) || c == '\\') {
        return word.to_string();
    }
    let end = if word.ends_with('\\') { "\\" } else { "" };
    format!("\"{word}{end}\"")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_one_word_in_a_shell() {
        for (path, expected) in [
            ("kit/job.toml", "kit/job.toml"),
            ("Fräse/job.toml", "Fräse/job.toml"),
            ("my kit", "\"my kit\""),
            ("it's", "\"it's\""),
            ("a$b 'c'", r"'a$b '\''c'\'''"),
            ("a;rm (1)&", "\"a;rm (1)&\""),
            ("~x", "\"~x\""),
            ("", "\"\""),
        ] {
            assert_eq!(posix_word(path), expected);
        }
    }

    #[test]
    fn paths_are_one_word_in_the_windows_command_line() {
        for (path, expected) in [
            (r"C:\kit\job.toml", r"C:\kit\job.toml"),
            (r"C:\my kit\", r#""C:\my kit\\""#),
            ("a&b", "\"a&b\""),
            ("a,b", "\"a,b\""),
        ] {
            assert_eq!(cmd_word(path), expected);
        }
    }
}
