//! Man pages and completions of all programs, from their command lines, in the folders where shells and `man` look.
//!
//! A build runs `all_programs --write-help FOLDER`, with FOLDER what is installed as `share`.

use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::process::ExitCode;

use clap::Command;
use clap_complete::{generate, Shell};
use clap_mangen::Man;

/// Writes the files of programs, by their names, below `share`, or one line about what went wrong.
pub fn main(share: &Path, programs: impl Iterator<Item = (&'static str, Command)>) -> ExitCode {
    match write(share, programs) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("all_programs: {}: {error}", share.display());
            ExitCode::FAILURE
        }
    }
}

fn write(share: &Path, programs: impl Iterator<Item = (&'static str, Command)>) -> io::Result<()> {
    let folder = |name: &str| {
        let folder = share.join(name);
        fs::create_dir_all(&folder).map(|()| folder)
    };
    let pages = folder("man/man1")?;
    let [bash, zsh, fish] =
        ["bash-completion/completions", "zsh/site-functions", "fish/vendor_completions.d"].map(folder);
    let (bash, zsh, fish) = (bash?, zsh?, fish?);
    // bash's is ros_pkg/env-hooks: rosbash has the file of rosrun's name already.
    fs::write(zsh.join("_rviz_camera_stream_rosrun"), include_str!("rosrun/rosrun.zsh"))?;
    fs::write(fish.join("rosrun.fish"), include_str!("rosrun/rosrun.fish"))?;
    for (name, command) in programs {
        // That of the command line names the package, for --version.
        let mut command = command.display_name(name).disable_help_subcommand(true);
        let files = [
            (Shell::Bash, bash.join(name)),
            (Shell::Zsh, zsh.join(format!("_{name}"))),
            (Shell::Fish, fish.join(format!("{name}.fish"))),
        ];
        for (shell, path) in files {
            generate(shell, &mut command, name, &mut File::create(path)?);
        }
        command.build();
        write_pages(&command, &pages)?;
    }
    Ok(())
}

/// Writes the man pages of a command and its subcommands, with the examples that its help begins with.
fn write_pages(command: &Command, folder: &Path) -> io::Result<()> {
    let page = Man::new(command.clone()).source(concat!("rviz_camera_stream ", env!("CARGO_PKG_VERSION")));
    let mut text = Vec::new();
    page.render(&mut text)?;
    let examples = command.get_before_help().map(ToString::to_string).unwrap_or_default();
    let examples: Vec<&str> = examples.lines().skip(1).map(str::trim_start).collect();
    // Of roff's letters, backslashes and dashes have to stay what they are when a line is copied.
    let examples = examples.join("\n").replace('\\', "\\e").replace('-', "\\-");
    text.extend_from_slice(format!(".SH EXAMPLES\n.nf\n{examples}\n.fi\n").as_bytes());
    fs::write(folder.join(page.get_filename()), text)?;
    command.get_subcommands().try_for_each(|inner| write_pages(inner, folder))
}
