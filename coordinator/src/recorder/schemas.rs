//! The schemas of what is logged: our own messages with the part of the descriptor set that they need, and the
//! one ROS message whose viewers know no protobuf.

use foxglove::Schema;
use prost::Message;
use prost_types::{FileDescriptorProto, FileDescriptorSet};
use std::collections::BTreeSet;

/// Schema of one of our messages, by its name within `oxplow.v1`.
pub(super) fn ours(message: &str) -> Schema {
    let all = FileDescriptorSet::decode(protocol::DESCRIPTORS).expect("the build wrote a descriptor set");
    let defining = all
        .file
        .iter()
        .find(|file| file.message_type.iter().any(|known| known.name() == message))
        .unwrap_or_else(|| panic!("`{message}` is one of our messages"));
    let mut needed = BTreeSet::new();
    collect_imports(&all.file, defining, &mut needed);
    let file = all.file.iter().filter(|file| needed.contains(file.name())).map(without_comments).collect();
    Schema::new(format!("oxplow.v1.{message}"), "protobuf", FileDescriptorSet { file }.encode_to_vec())
}

fn collect_imports(files: &[FileDescriptorProto], file: &FileDescriptorProto, needed: &mut BTreeSet<String>) {
    if needed.insert(file.name().to_owned()) {
        for imported in files.iter().filter(|other| file.dependency.contains(&other.name().to_owned())) {
            collect_imports(files, imported, needed);
        }
    }
}

fn without_comments(file: &FileDescriptorProto) -> FileDescriptorProto {
    FileDescriptorProto { source_code_info: None, ..file.clone() }
}
