//! The few lines of shell that bring the interface up before the command.

use std::ffi::{OsStr, OsString};
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

/// On the machine's own kernel: arguments are the command. 72 bytes: CAN FD frames.
pub const ON_OWN_KERNEL: &str = "\
ip link set lo up &&
ip link add dev vcan0 type vcan && ip link set vcan0 mtu 72 && ip link set up vcan0 || exit 125
exec \"$@\"
";

/// Before the command in user-mode Linux. `/dev`, `/proc` and the like are the guest's own.
const BOOT: &str = "\
PATH=/usr/sbin:/usr/bin:/sbin:/bin
export PATH
mount -t proc proc /proc
mount -t sysfs sysfs /sys
mount -t tmpfs tmpfs /run
mkdir -p /dev/shm /dev/pts
mount -t tmpfs -o mode=1777 tmpfs /dev/shm
mount -t devpts devpts /dev/pts
modules=/usr/lib/uml/modules/$(uname -r)/kernel
for module in net/can/can net/can/can-raw net/can/can-gw drivers/net/can/dev/can-dev drivers/net/can/vcan; do
    insmod $modules/$module.ko || echo \"no module $module\"
done
ip link set lo up
ip link add dev vcan0 type vcan && ip link set vcan0 mtu 72 && ip link set up vcan0 && echo 'vcan0 is up'
";

/// The first program of the guest: interface up, then the command in our folder with our environment, its output to
/// files of `job`, and its exit status to the file `status` there once all is written.
pub fn init(job: &Path, folder: &Path, environment: &[(OsString, OsString)], command: &[OsString]) -> Vec<u8> {
    let mut text = b"#!/bin/sh\n".to_vec();
    text.extend_from_slice(BOOT.as_bytes());
    text.extend_from_slice(b"job=");
    quote(&mut text, job.as_os_str());
    text.extend_from_slice(b"\ncd ");
    quote(&mut text, folder.as_os_str());
    text.extend_from_slice(b"\nenv -i");
    for (name, value) in environment {
        let mut pair = name.clone();
        pair.push("=");
        pair.push(value);
        text.push(b' ');
        quote(&mut text, &pair);
    }
    for word in command {
        text.push(b' ');
        quote(&mut text, word);
    }
    text.extend_from_slice(
        b" </dev/null >\"$job/stdout\" 2>\"$job/stderr\"\n\
        echo $? >\"$job/status.new\"\nsync\nmv \"$job/status.new\" \"$job/status\"\n\
        echo o >/proc/sysrq-trigger\nsleep 60\n",
    );
    text
}

/// Appends a word such that a shell takes it as it is.
fn quote(text: &mut Vec<u8>, word: &OsStr) {
    text.push(b'\'');
    for &byte in word.as_bytes() {
        match byte {
            b'\'' => text.extend_from_slice(br"'\''"),
            _ => text.push(byte),
        }
    }
    text.push(b'\'');
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Command;

    #[test]
    fn a_quoted_word_comes_out_of_a_shell_as_it_went_in() {
        for word in ["plain", "two words", "it's", "''", "$HOME `id` \"x\" \\ \n*?", "", "-n", "\u{e4}"] {
            let mut text = b"printf %s ".to_vec();
            quote(&mut text, OsStr::new(word));
            let told = Command::new("sh").arg("-c").arg(OsStr::from_bytes(&text)).output().unwrap();
            assert_eq!(String::from_utf8_lossy(&told.stdout), word);
        }
    }
}
