//! The task over a simulator that plays the reference back: what a perfect robot is paid, and how episodes end.

mod after_strike;
mod disturb;
mod episodes;
mod next_kick;
mod rewards;
mod simulator;
mod starts;
