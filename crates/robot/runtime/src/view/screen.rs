//! The terminal: taken at the beginning, given back at the end, also in a panic.

use std::io;
use std::time::Duration;

use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEventKind, KeyModifiers};
use ratatui::crossterm::terminal;

use super::View;
use crate::wire::{DAMPING_KEYS, Key};

/// What was typed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pressed {
    /// Keys of the remote, a bit each.
    Remote(u16),
    /// Damping, and the end.
    Quit,
}

/// The terminal.
pub struct Screen {
    terminal: DefaultTerminal,
}

impl Screen {
    /// Looks whether there is a terminal to take.
    ///
    /// # Errors
    /// If there is none.
    pub fn check() -> io::Result<()> {
        terminal::enable_raw_mode()?;
        terminal::disable_raw_mode()?;
        terminal::size().map(|_| ())
    }

    /// Takes the terminal.
    ///
    /// # Errors
    /// If the output is no terminal.
    pub fn take() -> io::Result<Self> {
        Ok(Self { terminal: ratatui::try_init()? })
    }

    /// Draws.
    ///
    /// # Errors
    /// If the terminal is gone.
    pub fn draw(&mut self, view: &View) -> io::Result<()> {
        self.terminal.draw(|frame| frame.render_widget(view, frame.area()))?;
        Ok(())
    }

    /// Waits up to `patience` for a key that means something. Another thread may draw meanwhile.
    ///
    /// # Errors
    /// If the terminal is gone.
    pub fn key(patience: Duration) -> io::Result<Option<Pressed>> {
        if !event::poll(patience)? {
            return Ok(None);
        }
        let Event::Key(key) = event::read()? else { return Ok(None) };
        if key.kind == KeyEventKind::Release {
            return Ok(None);
        }
        Ok(meaning(key.code, key.modifiers))
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        ratatui::restore();
    }
}

/// Keys of the keyboard as keys of the remote.
fn meaning(code: KeyCode, modifiers: KeyModifiers) -> Option<Pressed> {
    let remote =
        |keys: &[Key]| Some(Pressed::Remote(keys.iter().fold(0, |bits, key| bits | 1 << *key as u16)));
    match code {
        KeyCode::Char('c') if modifiers.contains(KeyModifiers::CONTROL) => Some(Pressed::Quit),
        KeyCode::Char('u') => remote(&[Key::L2, Key::Up]),
        KeyCode::Char('k') => remote(&[Key::R1, Key::X]),
        KeyCode::Char('b' | ' ') => remote(&DAMPING_KEYS),
        KeyCode::Char('q') => Some(Pressed::Quit),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_of_the_keyboard_are_keys_of_the_remote() {
        let typed = |c| meaning(KeyCode::Char(c), KeyModifiers::NONE);
        // L2 is bit 5, up bit 12, R1 bit 0, X bit 10, B bit 9.
        assert_eq!(typed('u'), Some(Pressed::Remote(0x1020)));
        assert_eq!(typed('k'), Some(Pressed::Remote(0x0401)));
        assert_eq!((typed('b'), typed(' ')), (Some(Pressed::Remote(0x0220)), typed('b')));
        assert_eq!((typed('q'), typed('x'), typed('c')), (Some(Pressed::Quit), None, None));
        assert_eq!(meaning(KeyCode::Char('c'), KeyModifiers::CONTROL), Some(Pressed::Quit));
    }
}
