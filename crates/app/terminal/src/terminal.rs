//! What every program of a terminal does alike.

use std::io::Write;

/// The command with options that take negative numbers: whoever reads one tells its range.
pub fn values_may_be_negative(command: clap::Command) -> clap::Command {
    command
        .mut_args(|arg| {
            let negative = arg.get_action().takes_values() && !arg.is_positional();
            if negative { arg.allow_negative_numbers(true) } else { arg }
        })
        .mut_subcommands(values_may_be_negative)
}

/// Ends the program with one error where standard output cannot be written, such as on a full disk: `println!` panics there.
pub fn end_at_a_full_disk() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        match info.payload_as_str().and_then(|words| words.strip_prefix("failed printing to stdout: ")) {
            Some(why) => {
                // Standard error may be on the same disk.
                let _ = writeln!(std::io::stderr(), "error: standard output: {why}");
                std::process::exit(2);
            }
            None => usual(info),
        }
    }));
}
