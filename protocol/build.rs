//! Compiles the `.proto` files with protox (no installed protoc is needed) and keeps the descriptor set
//! for the log, whose readers decode by it.

use std::{env, fs, path::PathBuf};

const FILES: &[&str] = &[
    "oxplow/v1/agent_to_coordinator.proto",
    "oxplow/v1/coordinator_to_agent.proto",
    "oxplow/v1/coordinator_to_observer.proto",
    "oxplow/v1/operator_to_coordinator.proto",
    "oxplow/v1/base.proto",
    "oxplow/v1/world.proto",
];

fn main() {
    println!("cargo:rerun-if-changed=proto");
    let descriptors = protox::compile(FILES, ["proto"]).expect("the .proto files compile");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    let encoded = prost_message_bytes(&descriptors);
    fs::write(out.join("oxplow.v1.descriptors.bin"), encoded).expect("OUT_DIR is writable");
    prost_build::Config::new().compile_fds(descriptors).expect("prost generates code");
}

fn prost_message_bytes(message: &impl protox::prost::Message) -> Vec<u8> {
    message.encode_to_vec()
}
