//! `~/get_logger_levels` and `~/set_logger_levels`, as in rclcpp with `enable_logger_service`.

use planesman_msgs::rcl_interfaces::{
    msg::{LoggerLevel, SetLoggerLevelsResult},
    srv::{
        GetLoggerLevelsRequest, GetLoggerLevelsResponse, SetLoggerLevelsRequest,
        SetLoggerLevelsResponse,
    },
};

use crate::logging;

/// Level of each logger; 0 (unset) if no level was set.
pub(crate) fn get(request: GetLoggerLevelsRequest) -> GetLoggerLevelsResponse {
    let level = |name: String| LoggerLevel {
        level: logging::level(&name),
        name,
    };
    GetLoggerLevelsResponse {
        levels: request.names.into_iter().map(level).collect(),
    }
}

/// Sets the level of each logger; 0 unsets it.
pub(crate) fn set(request: SetLoggerLevelsRequest) -> SetLoggerLevelsResponse {
    let result = |LoggerLevel { name, level }| {
        let outcome = logging::set_level(&name, level);
        SetLoggerLevelsResult {
            successful: outcome.is_ok(),
            reason: outcome.err().map_or_else(String::new, |e| e.to_string()),
        }
    };
    SetLoggerLevelsResponse {
        results: request.levels.into_iter().map(result).collect(),
    }
}
