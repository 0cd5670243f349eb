//! `~/get_type_description`: describes the types known to the node (REP 2016).

use planesman_msgs::{
    description::describe,
    type_description_interfaces::srv::{GetTypeDescriptionRequest, GetTypeDescriptionResponse},
};

/// Describes the requested type, if it has the requested hash.
pub(crate) fn answer(request: &GetTypeDescriptionRequest) -> GetTypeDescriptionResponse {
    let refused = |reason: String| GetTypeDescriptionResponse {
        failure_reason: reason,
        ..GetTypeDescriptionResponse::default()
    };
    let name = &request.type_name;
    match describe(name) {
        None => refused(format!("type '{name}' is unknown to this node")),
        Some(known) if known.hash != request.type_hash => refused(format!(
            "type '{name}' has the hash {} here, not '{}'",
            known.hash, request.type_hash
        )),
        Some(known) => GetTypeDescriptionResponse {
            successful: true,
            type_description: known.description,
            type_sources: match request.include_type_sources {
                true => known.sources,
                false => Vec::new(),
            },
            ..GetTypeDescriptionResponse::default()
        },
    }
}
