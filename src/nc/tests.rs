//! Programs with hand-made expected moves.
