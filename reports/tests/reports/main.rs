//! Every number of the reports computed again, the studies, and the program that prints them.

#![allow(clippy::unwrap_used)]

#[path = "../../../tests/browser/mod.rs"]
mod browser;
mod brunner_1988;
#[path = "../../../tests/foreign/mod.rs"]
mod foreign;
mod hopsan;
mod ibm_1966;
mod reproduce;
mod studies;
