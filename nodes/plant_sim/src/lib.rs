//! plant_sim
