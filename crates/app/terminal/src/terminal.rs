//! What every program of a terminal does alike.

/// The command with options that take negative numbers: whoever reads one tells its range.
pub fn values_may_be_negative(command: clap::Command) -> clap::Command {
    command
        .mut_args(|arg| {
            let negative = arg.get_action().takes_values() && !arg.is_positional();
            if negative { arg.allow_negative_numbers(true) } else { arg }
        })
        .mut_subcommands(values_may_be_negative)
}
