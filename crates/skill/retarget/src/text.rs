//! Words of a text with their places.

use std::path::Path;

use crate::RetargetError;

/// A larger file is no motion `[bytes]`.
pub(crate) const LARGEST: u64 = 1 << 28;

/// A word of the text.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Word<'a> {
    pub text: &'a str,
    /// From 1.
    pub line: usize,
    /// From 1, in characters.
    pub column: usize,
}

/// The words of a text, separated by white space, one after another.
#[derive(Clone, Debug)]
pub(crate) struct Words<'a> {
    path: &'a Path,
    /// What follows the line.
    rest: &'a str,
    line: &'a str,
    number: usize,
    /// Bytes of the line that are used up, and how many characters they are.
    used: [usize; 2],
    peeked: Option<Word<'a>>,
    comment: Option<char>,
}

impl<'a> Words<'a> {
    /// `comment`: a line that begins with this is skipped.
    pub fn new(path: &'a Path, text: &'a str, comment: Option<char>) -> Self {
        Self { path, rest: text, line: "", number: 0, used: [0; 2], peeked: None, comment }
    }

    /// The next word, without taking it.
    pub fn peek(&mut self) -> Option<Word<'a>> {
        if self.peeked.is_none() {
            self.peeked = self.advance();
        }
        self.peeked
    }

    fn advance(&mut self) -> Option<Word<'a>> {
        loop {
            let [bytes, characters] = self.used;
            let rest = &self.line[bytes..];
            let (space, rest) = rest.split_at(rest.len() - rest.trim_start().len());
            if !rest.is_empty() {
                let text = &rest[..rest.find(char::is_whitespace).unwrap_or(rest.len())];
                // From the word before, not from the line's start: a line can be as long as the file.
                let before = characters + space.chars().count();
                self.used = [bytes + space.len() + text.len(), before + text.chars().count()];
                return Some(Word { text, line: self.number, column: before + 1 });
            }
            let line = self.next_line()?;
            (self.number, self.used) = (self.number + 1, [0; 2]);
            let is_comment = self.comment.is_some_and(|c| line.trim_start().starts_with(c));
            self.line = if is_comment { "" } else { line };
        }
    }

    /// The next line: up to a line feed, a carriage return or both.
    fn next_line(&mut self) -> Option<&'a str> {
        if self.rest.is_empty() {
            return None;
        }
        let (line, rest) = self.rest.split_at(self.rest.find(['\n', '\r']).unwrap_or(self.rest.len()));
        let after = rest.strip_prefix("\r\n").or_else(|| rest.strip_prefix(['\n', '\r']));
        self.rest = after.unwrap_or(rest);
        Some(line)
    }

    /// Where the text has got to: the next word, or the end.
    pub fn error(&mut self, expected: impl Into<String>) -> RetargetError {
        match self.peek() {
            Some(word) => self.error_at(word, expected),
            None => self.error_found(expected, "the end of the file"),
        }
    }

    /// The error that something else was `found` at the end of the line.
    pub fn error_found(&self, expected: impl Into<String>, found: impl Into<String>) -> RetargetError {
        let (line, column) = (self.number.max(1), self.line.chars().count() + 1);
        self.error_found_at(Word { text: "", line, column }, expected, found)
    }

    /// The error that something else was `found` from `word` on.
    pub fn error_found_at(
        &self,
        word: Word<'_>,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> RetargetError {
        RetargetError::Text {
            path: self.path.to_owned(),
            line: word.line,
            column: word.column,
            expected: expected.into(),
            found: found.into(),
        }
    }

    /// The error that `word` is not what is expected.
    pub fn error_at(&self, word: Word<'_>, expected: impl Into<String>) -> RetargetError {
        // A word can be as long as the file.
        let shown: String = word.text.chars().take(40).flat_map(char::escape_debug).collect();
        self.error_found_at(word, expected, format!("'{shown}'"))
    }

    /// Takes the next word.
    pub fn word(&mut self, expected: &str) -> Result<Word<'a>, RetargetError> {
        match self.peek() {
            Some(word) => {
                self.peeked = None;
                Ok(word)
            }
            None => Err(self.error(expected)),
        }
    }

    /// Takes a word that must be `text`, in any case.
    pub fn keyword(&mut self, text: &str) -> Result<(), RetargetError> {
        let expected = format!("'{text}'");
        let word = self.word(&expected)?;
        if word.text.eq_ignore_ascii_case(text) { Ok(()) } else { Err(self.error_at(word, expected)) }
    }

    /// Takes a finite number.
    pub fn number(&mut self) -> Result<f64, RetargetError> {
        let word = self.word("a number")?;
        self.parse_number(word)
    }

    pub fn parse_number(&self, word: Word<'_>) -> Result<f64, RetargetError> {
        match word.text.parse::<f64>() {
            // Beyond this, sums and squares would not be finite any more.
            Ok(x) if x.abs() < 1e12 => Ok(x),
            _ => Err(self.error_at(word, "a finite number")),
        }
    }

    pub fn numbers<const N: usize>(&mut self) -> Result<[f64; N], RetargetError> {
        let mut out = [0.0; N];
        for x in &mut out {
            *x = self.number()?;
        }
        Ok(out)
    }

    /// Takes a whole number from 0 to `most`.
    pub fn count(&mut self, most: usize, what: &str) -> Result<usize, RetargetError> {
        let expected = format!("{what}: a whole number from 0 to {most}");
        let word = self.word(&expected)?;
        match word.text.parse::<usize>() {
            Ok(n) if n <= most => Ok(n),
            _ => Err(self.error_at(word, expected)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every word that is left, its line and its column.
    fn places<'a>(words: &mut Words<'a>) -> Vec<(&'a str, usize, usize)> {
        std::iter::from_fn(|| words.word("").ok().map(|w| (w.text, w.line, w.column))).collect()
    }

    #[test]
    fn a_line_ends_with_either_sign_or_both_and_may_be_long() {
        let mut words = Words::new(Path::new("a.txt"), "a\rb c\r\nd\n\n\r\re\r# no\rf\r", Some('#'));
        assert_eq!(
            places(&mut words),
            [("a", 1, 1), ("b", 2, 1), ("c", 2, 3), ("d", 3, 1), ("e", 7, 1), ("f", 9, 1)]
        );
        let long = "ä b ".repeat(1000);
        let places = places(&mut Words::new(Path::new("a.txt"), &long, None));
        assert_eq!((places.len(), places.last()), (2000, Some(&("b", 1, 3999))));
    }

    #[test]
    fn words_know_their_line_and_column() {
        let mut words = Words::new(Path::new("a.txt"), "# no\n  äb  c\n\n7 x", Some('#'));
        let expected = [("äb", 2, 3), ("c", 2, 7), ("7", 4, 1), ("x", 4, 3)];
        assert_eq!(places(&mut words), expected);
        assert_eq!(words.error("more").to_string(), "a.txt:4:4: expected more, found the end of the file");
    }
}
