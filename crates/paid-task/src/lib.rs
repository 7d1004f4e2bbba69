//! The MDP: references, observations, rewards, terminations, resets, ball and goal; presets.
