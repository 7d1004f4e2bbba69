//! What all programs have in common on a terminal.

/// The command line of a program: help at most 100 columns wide, and options that take negative numbers, whose range the option's own
/// parser states.
pub fn prepared(command: clap::Command) -> clap::Command {
    values_may_be_negative(command).max_term_width(100)
}

fn values_may_be_negative(command: clap::Command) -> clap::Command {
    command
        .mut_args(|arg| {
            let negative = arg.get_action().takes_values() && !arg.is_positional();
            if negative { arg.allow_negative_numbers(true) } else { arg }
        })
        .mut_subcommands(values_may_be_negative)
}
