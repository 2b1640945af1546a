//! Attacks on the installed service: its package, and the drop-in that opens its sandbox.

use crate::boards::{meniscus, said};
use crate::support::Scratch;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::process::Command;

/// The package's script does nothing as root in the folder of its user.
///
/// The script runs with commands that only write down how they are called.
#[test]
fn the_package_works_in_its_users_folder_as_that_user() {
    let scratch = Scratch::new("postinst");
    let (tools, calls) = (scratch.0.join("tools"), scratch.0.join("calls"));
    fs::create_dir(&tools).expect("a folder");
    let names = [
        "getent",
        "adduser",
        "install",
        "meniscus",
        "chown",
        "chmod",
        "cp",
        "mv",
        "ln",
        "runuser",
        "udevadm",
        "systemctl",
        "deb-systemd-helper",
        "deb-systemd-invoke",
    ];
    for name in names {
        let tool = tools.join(name);
        fs::write(&tool, format!("#!/bin/sh\necho {name} \"$@\" >>'{}'\n", calls.display()))
            .expect("written");
        fs::set_permissions(&tool, fs::Permissions::from_mode(0o755)).expect("executable");
    }
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../firmware-config/systemd/postinst");
    let path = format!("{}:/usr/bin:/bin", tools.display());
    let status =
        Command::new("/bin/sh").args([script, "configure"]).env("PATH", path).status().expect("a shell");
    assert!(status.success());
    let calls = fs::read_to_string(&calls).expect("calls");
    let flashes = "runuser -u meniscus -- meniscus flash shipped --to /var/lib/meniscus";
    assert!(calls.lines().any(|line| line == flashes), "{calls}");
    for line in calls.lines().filter(|line| *line != flashes) {
        let own = line == "install -d -o meniscus -g plugdev /var/lib/meniscus";
        assert!(own || !line.contains("/var/lib/meniscus"), "as root: {line}");
    }
}

/// A name in the service's configuration opens nothing but itself.
///
/// Names with ends of lines and commands behind them, with spaces, quotes, specifiers of systemd and variables of a shell.
#[test]
fn a_name_opens_nothing_but_itself() {
    let scratch = Scratch::new("unit");
    let configure = |publish: &str, out: &str| {
        let text = format!(
            "[images]\nsource = \"usb\"\n[time]\nservice = true\n[publishing]\npublish = [{publish:?}]\n[output]\nout = {out:?}\n"
        );
        fs::write(scratch.0.join("c.toml"), text).expect("written");
        let _before = fs::remove_file(scratch.0.join("configured.conf"));
        let output = meniscus(&scratch.0, &["service", "configure", "--config", "c.toml", "--to", "."]);
        (output, fs::read_to_string(scratch.0.join("configured.conf")).unwrap_or_default())
    };
    for (publish, out) in [
        ("unix:/srv/s\nExecStartPre=/bin/sh -c id\n#/sock", "/var/lib/meniscus/last-run"),
        ("unix:/run/meniscus/s", "/srv/out\nReadWritePaths=/etc"),
        ("unix:/run/meniscus/s", "/srv/out\rUser=root"),
    ] {
        let (output, drop_in) = configure(publish, out);
        assert!(
            !output.status.success() && said(&output).contains("control characters"),
            "{}",
            said(&output)
        );
        assert_eq!(drop_in, "", "nothing is written");
    }
    let (output, drop_in) = configure("unix:/srv/a b/sock", "/srv/x /etc \"%h $HOME\\");
    assert!(output.status.success(), "{}", said(&output));
    let opened: Vec<&str> = drop_in.lines().filter_map(|line| line.strip_prefix("ReadWritePaths=")).collect();
    // One word in quotes each, as systemd.syntax(7) takes it apart.
    assert_eq!(opened, [r#""/srv/a b""#, r#""/srv/x /etc \"%%h $HOME\\""#], "{drop_in}");
    let known = ["#", "[Service]", "ExecStart=", "RuntimeDirectory", "ReadWritePaths="];
    let foreign = drop_in.lines().find(|line| !known.iter().any(|start| line.starts_with(start)));
    assert_eq!(foreign, None, "{drop_in}");
}
