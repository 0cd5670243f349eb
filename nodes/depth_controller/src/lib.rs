//! depth_controller
