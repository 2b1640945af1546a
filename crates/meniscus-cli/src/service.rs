//! `meniscus service`: the installed service and its configuration file.

use crate::run::{self, Needs};
use anyhow::{Context, ensure};
use meniscus_platform::files::write_whole;
use meniscus_report::checks::{Check, table};
use serde_json::json;
use std::ffi::OsString;
use std::fmt::Write;
use std::path::{Path, PathBuf, absolute};

/// Configuration of the installed service.
const CONFIG: &str = "/etc/meniscus/meniscus.toml";

/// Folder of the unit's drop-ins.
const DROP_INS: &str = "/etc/systemd/system/meniscus.service.d";

/// Name of the drop-in that `configure` writes.
const DROP_IN: &str = "configured.conf";

/// Folder that the unit may write.
const STATE: &str = "/var/lib/meniscus";

/// Folder of the sockets.
const RUNTIME: &str = "/run/meniscus";

/// Addresses of the local networks, for a server that listens everywhere.
const LOCAL: &str = "localhost link-local 192.168.0.0/16 10.0.0.0/8 172.16.0.0/12";

/// Multicast addresses, in which ROS 2 nodes find each other.
const MULTICAST: &str = "multicast";

/// Folders that the unit's sandbox hides.
const HIDDEN: [&str; 3] = ["/home", "/root", "/run/user"];

/// Check the installed service, or open its sandbox.
///
/// The service runs `meniscus run --config /etc/meniscus/meniscus.toml`. Its unit reaches no network, no serial device and no
/// folder but its own. `configure` writes a drop-in that opens what the file asks for, and nothing else.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus service check\n  meniscus service check --config try.toml --json\n  sudo meniscus service configure\n  meniscus service configure --config try.toml --to ."
)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    /// Say what the service would do, and what is wrong.
    ///
    /// Model, signature, setup and every option are checked as at a start; no camera is looked for (`meniscus doctor` does).
    /// The exit status is 1 if not all is well.
    #[command(
        after_help = "Examples:\n  meniscus service check\n  meniscus service check --config try.toml --to . --json"
    )]
    Check {
        /// The configuration.
        #[arg(long, value_name = "FILE.toml", default_value = CONFIG)]
        config: PathBuf,
        /// Folder of the unit's drop-ins.
        #[arg(long, value_name = "FOLDER", default_value = DROP_INS)]
        to: PathBuf,
        /// Print one JSON object.
        #[arg(long)]
        json: bool,
    },
    /// Write the drop-in that opens the unit's sandbox.
    #[command(
        after_help = "Examples:\n  sudo meniscus service configure\n  meniscus service configure --config try.toml --to ."
    )]
    Configure {
        /// The configuration.
        #[arg(long, value_name = "FILE.toml", default_value = CONFIG)]
        config: PathBuf,
        /// Folder of the unit's drop-ins.
        #[arg(long, value_name = "FOLDER", default_value = DROP_INS)]
        to: PathBuf,
    },
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    match &arguments.what {
        // The unit starts elsewhere.
        What::Check { config, to, json } => check(&absolute(config)?, to, *json),
        What::Configure { config, to } => configure(&absolute(config)?, to),
    }
}

/// Returns what the service of the file at `config` needs, all of it checked as at a start.
fn needs(config: &Path) -> anyhow::Result<Needs> {
    let words = ["meniscus", "run", "--config"].map(OsString::from);
    let words: Vec<OsString> = words.into_iter().chain([config.into()]).collect();
    let arguments = crate::run_arguments(&words)?;
    ensure!(
        arguments.is_service(),
        "{}: the service would end by itself: write service = true under [time]",
        config.display()
    );
    let needs = run::needs(&arguments).with_context(|| format!("{} cannot be run", config.display()))?;
    // A line of a unit file cannot hold them, and what stands behind a line's end would be a line of its own.
    let Needs { serial, sockets, written, read, .. } = &needs;
    let named = serial.iter().chain(sockets).chain(written).chain(read).map(PathBuf::as_path).chain([config]);
    for path in named {
        let text = path.to_str().with_context(|| format!("{}: systemd takes UTF-8 alone", path.display()))?;
        ensure!(!text.chars().any(char::is_control), "{path:?}: a name with control characters is not taken");
    }
    Ok(needs)
}

/// Returns `path` as one word of a unit file (systemd.syntax(7)): in quotes, with `%`, `"` and `\` spelled as themselves.
fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\"").replace('%', "%%"))
}

/// Returns `path` as one word of a command line in a unit file, where `$` begins a variable, too.
fn argument(path: &Path) -> String {
    quoted(path).replace('$', "$$")
}

fn configure(config: &Path, to: &Path) -> anyhow::Result<()> {
    let needs = needs(config)?;
    let text = drop_in(&needs, config);
    let file = to.join(DROP_IN);
    write_whole(&file, text.as_bytes()).with_context(|| {
        format!("{} cannot be written; the unit's folder is root's: use sudo", file.display())
    })?;
    println!("{}:", file.display());
    opened(&needs).iter().for_each(|line| println!("  {line}"));
    println!("now: sudo systemctl daemon-reload && sudo systemctl restart meniscus");
    Ok(())
}

fn check(config: &Path, to: &Path, as_json: bool) -> anyhow::Result<()> {
    let is = |it: bool| f64::from(u8::from(it));
    let needs = needs(config);
    let fault = needs.as_ref().err().map(crate::errors::line);
    let hidden: Vec<&PathBuf> =
        needs.iter().flat_map(|needs| &needs.read).filter(|path| is_hidden(path)).collect();
    let written = std::fs::read_to_string(to.join(DROP_IN)).ok();
    let current = needs.as_ref().ok().map(|needs| {
        let wanted = drop_in(needs, config);
        // A unit that needs nothing does not need a drop-in either.
        written.as_ref() == Some(&wanted)
            || (written.is_none() && wanted == drop_in(&Needs::default(), Path::new(CONFIG)))
    });
    let known = |it: Option<bool>| it.map_or(f64::NAN, is);
    let checks = [
        Check::exactly("configuration_good", is(needs.is_ok()), "1", 1.0),
        Check::exactly("files_visible", known(needs.is_ok().then_some(hidden.is_empty())), "1", 1.0),
        Check::exactly("sandbox_opened", known(current), "1", 1.0),
    ];
    let remedies = [
        fault.unwrap_or_default(),
        format!("the unit hides {}: put it into /etc/meniscus", joined(&hidden)),
        "sudo meniscus service configure".into(),
    ];
    let open = needs.as_ref().map(opened).unwrap_or_default();
    let missed = || checks.iter().zip(&remedies).filter(|(check, _)| check.missed() && check.value.is_some());
    if as_json {
        let remedies: serde_json::Map<String, serde_json::Value> =
            missed().map(|(check, remedy)| (check.name.clone(), json!(remedy))).collect();
        let report = json!({
            "command": "meniscus service check",
            "config": config,
            "opens": open,
            "remedies": remedies,
            "checks": checks,
        });
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        print!("{}", table(&checks));
        open.iter().for_each(|line| println!("{line}"));
        missed().for_each(|(check, remedy)| println!("{}: {remedy}", check.name));
    }
    let number = checks.iter().filter(|check| check.missed()).count();
    ensure!(number == 0, "{number} of {} checks missed", checks.len());
    Ok(())
}

fn is_hidden(path: &Path) -> bool {
    HIDDEN.iter().any(|folder| path.starts_with(folder))
}

fn joined(paths: &[&PathBuf]) -> String {
    let all: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
    all.join(", ")
}

/// Openings of the sandbox, a line each.
fn opened(needs: &Needs) -> Vec<String> {
    let mut lines = Vec::new();
    if needs.peers.iter().any(|peer| !peer.is_loopback()) {
        lines.push(format!("network: {}", addresses(needs)));
    } else if !needs.peers.is_empty() {
        lines.push("network: this machine alone".into());
    }
    lines.extend(needs.serial.iter().map(|device| format!("device: {}", device.display())));
    lines.extend(needs.sockets.iter().map(|socket| format!("socket: {}", socket.display())));
    lines.extend(outside(needs).iter().map(|folder| format!("folder: {}", folder.display())));
    if lines.is_empty() {
        lines.push("nothing has to be opened: the service reads its camera and keeps its reports".into());
    }
    lines
}

/// Addresses for `IPAddressAllow`.
fn addresses(needs: &Needs) -> String {
    let multicast = needs.multicast.then(|| MULTICAST.to_owned());
    if needs.peers.iter().any(|peer| peer.is_unspecified()) {
        return [LOCAL.to_owned()].into_iter().chain(multicast).collect::<Vec<_>>().join(" ");
    }
    let all: Vec<String> = needs
        .peers
        .iter()
        .map(|peer| if peer.is_loopback() { "localhost".into() } else { peer.to_string() })
        .chain(multicast)
        .collect();
    all.join(" ")
}

/// Folders that are written and are not the unit's own.
fn outside(needs: &Needs) -> Vec<PathBuf> {
    let of_sockets = needs.sockets.iter().filter_map(|socket| socket.parent());
    let folders = needs.written.iter().map(PathBuf::as_path).chain(of_sockets);
    let mut all: Vec<PathBuf> = folders
        .filter(|folder| !folder.starts_with(STATE) && !folder.starts_with(RUNTIME))
        .map(Path::to_path_buf)
        .collect();
    all.sort();
    all.dedup();
    all
}

/// The drop-in for `needs`.
fn drop_in(needs: &Needs, config: &Path) -> String {
    let mut text = format!(
        "# Written by `meniscus service configure` from {}: what the unit's sandbox lets through.\n[Service]\n",
        config.display()
    );
    // Writing into a string cannot fail.
    if config != Path::new(CONFIG) {
        let _ = writeln!(text, "ExecStart=\nExecStart=/usr/bin/meniscus run --config {}", argument(config));
    }
    if !needs.peers.is_empty() {
        let _ =
            writeln!(text, "RestrictAddressFamilies=AF_INET AF_INET6\nIPAddressAllow={}", addresses(needs));
    }
    if !needs.serial.is_empty() {
        text += "SupplementaryGroups=dialout\n";
    }
    for device in &needs.serial {
        let _ = writeln!(text, "DeviceAllow={} rw", quoted(device));
    }
    if needs.sockets.iter().any(|socket| socket.starts_with(RUNTIME)) {
        text += "RuntimeDirectory=meniscus\nRuntimeDirectoryMode=0750\n";
    }
    for folder in outside(needs) {
        let _ = writeln!(text, "ReadWritePaths={}", quoted(&folder));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_drop_in_opens_what_is_needed_and_nothing_else() {
        let closed = drop_in(&Needs::default(), Path::new(CONFIG));
        assert_eq!(closed.lines().count(), 2, "{closed}");
        let needs = Needs {
            peers: ["192.168.1.5", "127.0.0.1"].map(|peer| peer.parse().expect("an address")).into(),
            multicast: false,
            serial: [PathBuf::from("/dev/ttyUSB0")].into(),
            sockets: ["/run/meniscus/estimates", "/srv/robot/liquid"].map(PathBuf::from).into(),
            written: ["/var/lib/meniscus/last-run", "/srv/out"].map(PathBuf::from).into(),
            read: ["/home/me/glass.toml"].map(PathBuf::from).into(),
        };
        let opened = drop_in(&needs, Path::new("/etc/other.toml"));
        for line in [
            "ExecStart=/usr/bin/meniscus run --config \"/etc/other.toml\"",
            "RestrictAddressFamilies=AF_INET AF_INET6",
            "IPAddressAllow=localhost 192.168.1.5",
            "DeviceAllow=\"/dev/ttyUSB0\" rw",
            "RuntimeDirectory=meniscus",
            "ReadWritePaths=\"/srv/out\"",
            "ReadWritePaths=\"/srv/robot\"",
        ] {
            assert!(opened.lines().any(|have| have == line), "{line} is missing in:\n{opened}");
        }
        assert!(!opened.contains("/var/lib/meniscus") && is_hidden(Path::new("/home/me/glass.toml")));
        assert_eq!(argument(Path::new("/a \"b\\%n$HOME")), r#""/a \"b\\%%n$$HOME""#);
        let everywhere = Needs { peers: ["0.0.0.0".parse().expect("an address")].into(), ..Needs::default() };
        assert_eq!(addresses(&everywhere), LOCAL);
        let ros = Needs { multicast: true, ..everywhere };
        assert_eq!(addresses(&ros), format!("{LOCAL} multicast"));
    }
}
