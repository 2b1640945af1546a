//! From the flags of a run to its configuration: what contradicts itself is refused before anything is opened.

use super::Arguments;
use super::config::{Controlling, Front, Output, Publishing, RunConfig, RunEnd, Targets};
use super::motion_source::MotionSource;
use super::motion_topic::TopicMotion;
use super::source::{RecordingSource, Source};
use crate::bars::is_plain_terminal;
use crate::kind::check_ending;
use crate::profile::Profile;
use crate::variant::VariantName;
use anyhow::{Context, bail, ensure};
use meniscus::latent::decoder::Selection;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::recording::GROUP_NAMES;
use meniscus_platform::realtime::Priority;
use meniscus_service::clock_map::LeastLatency;
use meniscus_service::live::Silence;
use std::io::IsTerminal;

/// Standard deviation of a least latency that somebody measured, s.
const MEASURED_LATENCY_STD_S: f64 = 0.0005;

/// Length of a run without --seconds, s.
const SECONDS: f64 = 10.0;

impl TryFrom<&Arguments> for RunConfig {
    type Error = anyhow::Error;

    fn try_from(arguments: &Arguments) -> anyhow::Result<Self> {
        let frames = frames(arguments.seconds.unwrap_or(SECONDS))?;
        ensure!(
            (0.0..=60.0).contains(&arguments.field_hz),
            "--field-hz {} is out of range: 0 to 60",
            arguments.field_hz
        );
        for (path, ending) in [(&arguments.turns, "csv"), (&arguments.estimates, "safetensors")] {
            path.as_deref().map_or(Ok(()), |path| check_ending(path, ending))?;
        }
        let source = Source::try_from(arguments)?;
        if !source.is_bus() {
            ensure!(!arguments.service, "--service is for a camera on a bus: add --source usb");
            ensure!(
                arguments.truth.is_none(),
                "--truth is for a camera on a bus; a recording brings its own: leave it out"
            );
            ensure!(arguments.serial.is_none(), "--serial is for a camera on a bus: add --source usb");
        }
        let endless = arguments.service || (arguments.page.view && arguments.seconds.is_none());
        let front = if arguments.service {
            Front::Service
        } else if arguments.page.view {
            Front::Page
        } else if cfg!(feature = "desk")
            && !arguments.json
            && std::io::stdout().is_terminal()
            && !is_plain_terminal()
        {
            Front::Dashboard
        } else {
            Front::Progress
        };
        let profile = arguments.profile.as_deref().map(Profile::read).transpose()?;
        let motion = MotionSource::parse(&arguments.motion, profile.as_ref())?;
        let ros2 = arguments.ros2.config()?;
        if let Some(MotionSource::Topic(TopicMotion { topic, .. })) = &motion {
            ensure!(ros2.is_some(), "--motion ros2:{topic} is read by the ROS 2 node of the run: add --ros2");
        }
        Ok(Self {
            source,
            source_name: arguments.source.display().to_string(),
            model: arguments.model.clone(),
            model_name: arguments.model.display().to_string(),
            profile: profile.clone(),
            setup: arguments.setup.clone(),
            serial: arguments.serial.clone(),
            seed: arguments.seed,
            frames,
            end: if endless { RunEnd::WhenStopped } else { RunEnd::AfterFrames },
            out: arguments.out.clone(),
            turn_table: arguments.turns.clone(),
            estimates: arguments.estimates.clone(),
            publishing: Publishing {
                destinations: arguments.publish.clone(),
                field_hz: arguments.field_hz,
                controller: controlling(arguments, profile.as_ref())?,
            },
            variant: arguments.variant.into(),
            fields: groups(arguments)?,
            silence: if arguments.patient { Silence::WaitOut } else { Silence::Bridge },
            priority: Priority::real_time_if(arguments.realtime || arguments.service),
            truth: arguments.truth.as_deref().map(RecordingSource::from),
            among: arguments.among.clone(),
            latency: latency(arguments.camera_latency_ms)?,
            motion,
            page: arguments.page.config(),
            foxglove: arguments.foxglove.config(),
            ros2,
            #[cfg(feature = "ros2")]
            motion_line: arguments.motion.line()?,
            front,
            output: if arguments.json { Output::Json } else { Output::Text },
            targets: if arguments.check { Targets::Enforced } else { Targets::Reported },
        })
    }
}

/// Returns the records for a controller that the flags ask for.
fn controlling(arguments: &Arguments, profile: Option<&Profile>) -> anyhow::Result<Controlling> {
    if !arguments.controller {
        return Ok(Controlling::Off);
    }
    let plans =
        arguments.plan.as_deref().map(|plan| arguments.motion.plan_wire(plan, profile)).transpose()?;
    Ok(Controlling::On(plans))
}

/// Returns the least latency of the camera; the one of a camera that was not measured without a value.
fn latency(measured_ms: Option<f64>) -> anyhow::Result<LeastLatency> {
    let Some(measured_ms) = measured_ms else { return Ok(LeastLatency::UNKNOWN_CAMERA) };
    ensure!(
        (0.0..=100.0).contains(&measured_ms),
        "--camera-latency-ms {measured_ms} is out of range: 0 to 100. Measure it with a light that the host switches"
    );
    Ok(LeastLatency { mean_s: 1e-3 * measured_ms, std_s: MEASURED_LATENCY_STD_S })
}

/// Returns the whole frames in `seconds`, at least a window and a second.
fn frames(seconds: f64) -> anyhow::Result<usize> {
    if !(1.5..=3600.0).contains(&seconds) {
        bail!("--seconds {seconds} is out of range: 1.5 to 3600");
    }
    Ok((seconds / FRAME_INTERVAL_S).round() as usize)
}

/// Returns the groups that --fields names.
fn groups(arguments: &Arguments) -> anyhow::Result<Selection> {
    let Arguments { fields, field_hz, variant, .. } = arguments;
    ensure!(
        *field_hz == 0.0 || *variant == VariantName::Full,
        "--field-hz hands on the full field, which --variant small does not estimate"
    );
    let groups = match fields.as_str() {
        "all" => return Ok(Selection::ALL),
        "none" => Selection::NONE,
        list => list.split(',').try_fold(Selection::NONE, |groups, name| {
            let index = GROUP_NAMES.iter().position(|known| *known == name.trim());
            let index = index.with_context(|| {
                format!(
                    "--fields knows no group '{name}': take of {}, or all, or none",
                    GROUP_NAMES.join(", ")
                )
            })?;
            anyhow::Ok(groups.with(index))
        })?,
    };
    ensure!(
        *field_hz == 0.0 || groups == Selection::ALL,
        "--field-hz hands on the full field, which --fields {fields} leaves out in part"
    );
    Ok(groups)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    /// The flags as the program parses them.
    #[derive(clap::Parser)]
    struct Program {
        #[command(flatten)]
        arguments: Arguments,
    }

    fn config(words: &[&str]) -> anyhow::Result<RunConfig> {
        let all = ["run"].iter().chain(words);
        RunConfig::try_from(&Program::try_parse_from(all)?.arguments)
    }

    fn refusal(words: &[&str]) -> String {
        config(words).map_or_else(|error| format!("{error:#}"), |_| format!("{words:?} is accepted"))
    }

    #[test]
    fn flags_become_a_configuration() {
        let plain = config(&["--json"]).expect("no flag is needed");
        assert_eq!((plain.frames, plain.end, plain.front), (600, RunEnd::AfterFrames, Front::Progress));
        assert!(matches!(&plain.source, Source::Rendered { recording: RecordingSource::Shipped, .. }));
        assert_eq!(config(&["--view"]).expect("a page").end, RunEnd::WhenStopped);
        assert_eq!(config(&["--view", "--seconds", "3"]).expect("a page").end, RunEnd::AfterFrames);
        let service = config(&["--source", "usb", "--service"]).expect("a service");
        assert_eq!((service.front, service.priority), (Front::Service, Priority::RealTime));
        let simulated = config(&["--source", "simulated-usb:unplug"]).expect("a trouble by name");
        assert!(matches!(simulated.source, Source::SimulatedUsb { trouble: Some(_), .. }));
        assert_eq!(config(&["--patient"]).expect("patient").silence, Silence::WaitOut);
    }

    #[test]
    fn contradictions_are_refused_before_anything_is_opened() {
        for (words, why) in [
            (&["--seconds", "1"][..], "out of range: 1.5 to 3600"),
            (&["--service"], "--service is for a camera on a bus"),
            (&["--serial", "123"], "--serial is for a camera on a bus"),
            (&["--field-hz=-1"], "--field-hz -1 is out of range"),
            (&["--estimates", "a.csv"], "name it a.safetensors"),
            (&["--motion-lag-ms", "5"], "are for --motion udp"),
            (&["--truth", "shipped"], "a recording brings its own"),
            (&["--source", "replay"], "--source replay needs the recording"),
            (&["some.mcap"], "a recording stands behind --source: meniscus run --source some.mcap"),
            (&["--source", "simulated-usb:nonsense"], "no trouble is called `nonsense`"),
            (&["--fields", "q,x"], "--fields knows no group 'x'"),
            (&["--fields", "q", "--field-hz", "2"], "--field-hz hands on the full field"),
            (&["--variant", "small", "--field-hz", "2"], "--variant small does not estimate"),
            (&["--motion", "udp:nowhere"], "udp:HOST:PORT"),
            (&["--motion", "udp:0.0.0.0:9000"], "--motion-from ADDRESS"),
            (&["--motion", "truth", "--motion-from", "10.0.0.1"], "are for --motion udp"),
            (&["--motion", "truth", "--motion-joint", "lift"], "are for --motion ros2:TOPIC"),
            (&["--motion", "ros2:/odom"], "add --ros2"),
            (&["--motion", "ros2:/2nd"], "is no name of a topic"),
            (&["--motion", "ros2:"], "is no name of a topic"),
            (&["--motion", "ros2:/tf"], "--motion-frames PARENT,CHILD"),
            (&["--motion", "ros2:/tf", "--motion-frames", "world,world"], "two different frames"),
            (&["--motion", "ros2:/odom", "--motion-clock", "robot"], "expected host or sender"),
            (
                &["--motion", "ros2:/j", "--motion-axis", "0,0,0"],
                "--motion-axis 0,0,0: expected three numbers",
            ),
        ] {
            assert!(refusal(words).contains(why), "{words:?}: {}", refusal(words));
        }
    }
}
