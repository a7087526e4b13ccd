# What CI runs, and the front door.

# Format, lints, all tests: what CI runs.
check:
    cargo fmt --all --check
    cargo clippy --workspace --all-targets --locked -- -D warnings
    cargo test --workspace --locked

# The front door: covers a floor, loses a robot, finishes.
demo *ARGS:
    cargo run --release --locked -- demo {{ARGS}}

# Plays random faults over many seeds: `just seeds 0 1000`.
seeds from to:
    cargo run --release --locked -- rehearse scenarios/demo.toml --random-faults --seeds {{from}}..{{to}}

# Writes the floors of maps/ anew from their generator.
maps:
    cargo run -p terrain --example generate_maps
