//! Questions on the terminal. A question is repeated after an unusable answer; the end of the input (Ctrl-D) and Ctrl-C
//! end the program, before anything is written.
//!
//! Questions go to standard error, since a program's result may go to standard output.

use std::io::{self, BufRead, Write};
use std::thread;
use std::time::Duration;

use crate::lifecycle::EndRequest;

/// Length limit of an answer, bytes.
const MAX_BYTES: u64 = 1000;
/// Unusable answers in a row until the dialog gives up: more are no person's.
pub const MAX_ATTEMPTS: u32 = 30;

/// Questions to one reader, asked on one writer.
pub struct Dialog<'a> {
    input: &'a mut dyn BufRead,
    terminal: &'a mut dyn Write,
}

/// A dialog that ends without an answer.
#[derive(Debug, thiserror::Error)]
pub enum DialogError {
    /// The input ended.
    #[error("ended before the last answer; nothing written")]
    Ended,
    /// Too many unusable answers.
    #[error("no usable answer to: {0}")]
    Unusable(String),
    /// The input cannot be read.
    #[error("cannot read the answer: {0}")]
    Input(io::Error),
    /// The question cannot be shown.
    #[error("cannot show the question: {0}")]
    Output(io::Error),
}

impl<'a> Dialog<'a> {
    /// A dialog that reads answers from `input` and asks on `terminal`.
    pub fn new(input: &'a mut dyn BufRead, terminal: &'a mut dyn Write) -> Self {
        Self { input, terminal }
    }

    /// Shows a text and ends its line.
    ///
    /// # Errors
    /// [`DialogError::Output`].
    pub fn say(&mut self, text: &str) -> Result<(), DialogError> {
        writeln!(self.terminal, "{text}").and_then(|()| self.terminal.flush()).map_err(DialogError::Output)
    }

    /// Asks until `read` accepts the answer, and shows its reason when it does not.
    ///
    /// # Errors
    /// [`DialogError`].
    pub fn answer<A>(&mut self, question: &str, read: impl Fn(&str) -> Result<A, String>) -> Result<A, DialogError> {
        for _ in 0..MAX_ATTEMPTS {
            write!(self.terminal, "{question}").and_then(|()| self.terminal.flush()).map_err(DialogError::Output)?;
            let mut line = String::new();
            match io::Read::take(&mut *self.input, MAX_BYTES).read_line(&mut line) {
                Ok(0) => {
                    self.say("")?;
                    return Err(DialogError::Ended);
                }
                Ok(_) => {}
                Err(error) if error.kind() == io::ErrorKind::InvalidData => line.clear(),
                Err(error) => return Err(DialogError::Input(error)),
            }
            match read(line.trim()) {
                Ok(answer) => return Ok(answer),
                Err(reason) => self.say(&format!("  {reason}"))?,
            }
        }
        Err(DialogError::Unusable(question.trim().to_owned()))
    }

    /// Asks for yes or no.
    ///
    /// # Errors
    /// [`DialogError`].
    pub fn agrees(&mut self, question: &str, default: bool) -> Result<bool, DialogError> {
        self.answer(question, |text| match text.to_lowercase().as_str() {
            "" => Ok(default),
            "y" | "yes" => Ok(true),
            "n" | "no" => Ok(false),
            _ => Err("answer y or n".to_owned()),
        })
    }
}

/// Ends the program on Ctrl-C while it waits for an answer, with one line in the program's name, after `clean_up`.
///
/// # Errors
/// A signal handler or the thread cannot be installed.
pub fn end_on_signals(program: &'static str, clean_up: impl FnOnce() + Send + 'static) -> io::Result<()> {
    let end = EndRequest::watch_signals()?;
    let waiting = move || {
        end.wait_for(Duration::MAX);
        clean_up();
        eprintln!("\n{program}: {}", DialogError::Ended);
        std::process::exit(1);
    };
    thread::Builder::new().name("signals".to_owned()).spawn(waiting).map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(text: &str) -> Result<u32, String> {
        text.parse().map_err(|_| format!("'{text}' is not a number"))
    }

    #[test]
    fn a_question_is_repeated_until_the_answer_is_usable() {
        let (mut input, mut shown) = (&b"many\n 7 \ny\n\n"[..], Vec::new());
        let mut dialog = Dialog::new(&mut input, &mut shown);
        assert_eq!(dialog.answer("How many? ", number).unwrap(), 7);
        assert!(dialog.agrees("Sure? ", false).unwrap());
        assert!(!dialog.agrees("Sure? ", false).unwrap(), "an empty answer is the default");
        assert!(matches!(dialog.agrees("Sure? ", false), Err(DialogError::Ended)));
        let shown = String::from_utf8(shown).unwrap();
        assert_eq!(shown, "How many?   'many' is not a number\nHow many? Sure? Sure? Sure? \n");
    }

    #[test]
    fn endless_answers_end_the_dialog() {
        let (mut input, mut shown) = (io::BufReader::new(io::repeat(b'x')), Vec::new());
        let result = Dialog::new(&mut input, &mut shown).answer("How many? ", number);
        assert!(matches!(result, Err(DialogError::Unusable(question)) if question == "How many?"));
    }
}
