//! Log on standard error, for those who ask for it by `RUST_LOG`.
//!
//! Nothing is logged unless it is set: what a person has to know is printed in any case. Targets are the crates' modules, as
//! `meniscus_usb::camera` and `meniscus_discover::sizing`. A turn of the worker logs nothing.

/// Variable that chooses targets and levels, as `info` or `meniscus_usb=debug,warn`.
const VARIABLE: &str = "RUST_LOG";

/// Begins the log.
pub(super) fn begin() {
    let chosen = env_logger::Env::default().filter_or(VARIABLE, "off");
    let logger = env_logger::Builder::from_env(chosen).build();
    let level = logger.filter();
    let logger: Box<dyn log::Log> = Box::new(logger);
    #[cfg(feature = "ros2")]
    let logger = meniscus_ros::counting(logger);
    // A second one, as of a program that contains this command, keeps the first.
    if log::set_boxed_logger(logger).is_ok() {
        log::set_max_level(level);
        log::info!("meniscus {}", env!("CARGO_PKG_VERSION"));
    }
}
