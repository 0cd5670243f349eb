//! rosidl
