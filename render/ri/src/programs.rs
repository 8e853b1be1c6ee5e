//! `Procedural "RunProgram"`: programs that are told a level of detail and a request on a line, and answer with RIB that ends in
//! byte 0377 (RISpec 5.8). A program is started once and asked again and again. None runs without permission: a scene may come from
//! anybody.

use std::collections::HashMap;
use std::io::{BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

/// How long an answer may take if nothing else is said.
pub const PATIENCE: Duration = Duration::from_secs(60);
/// How long an answer takes before it is said what is waited for.
const LONG: Duration = Duration::from_secs(5);
/// Maximum length of an answer, bytes; less where reading may not take as much.
const MAX_ANSWER: usize = 1 << 28;

/// Programs that a stream may run.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Permission {
    /// None: that a stream asks for one is an error.
    #[default]
    None,
    /// None: what a stream asks for is passed over with a warning, as in a check.
    PassOver,
    /// Those at these resolved paths.
    Named(Vec<PathBuf>),
    /// All.
    All,
}

/// The resolved path of a program: a name with a slash counts from the working folder, any other is looked for along `PATH`.
pub fn resolve(name: &str) -> Option<PathBuf> {
    let found = |path: &Path| path.canonicalize().ok().filter(|path| path.is_file());
    if name.contains('/') {
        return found(Path::new(name));
    }
    std::env::split_paths(&std::env::var_os("PATH")?).find_map(|folder| found(&folder.join(name)))
}

impl Permission {
    /// The path of a program, given with its arguments on one line, that may run; none if it is to be passed over. An error says what
    /// would have run.
    pub fn path_of(&self, program: &str) -> Result<Option<PathBuf>, String> {
        let name = program.split_whitespace().next().ok_or("RunProgram needs a program")?;
        let path = resolve(name);
        let is_allowed = match self {
            Permission::None => false,
            Permission::PassOver => return Ok(None),
            Permission::Named(paths) => path.as_ref().is_some_and(|path| paths.contains(path)),
            Permission::All => true,
        };
        match path {
            Some(path) if is_allowed => Ok(Some(path)),
            None if is_allowed => Err(format!("program `{name}` was not found")),
            path => {
                let place = path.map_or("not found on this machine".into(), |path| path.display().to_string());
                Err(format!(
                    "would run the program `{}` ({place}), which is not allowed; --allow-program {} allows it, --allow-programs allows all",
                    program.escape_debug(),
                    name.escape_debug()
                ))
            }
        }
    }
}

struct Running {
    child: Child,
    requests: Sender<String>,
    answers: Receiver<Result<Vec<u8>, String>>,
}

/// The programs of a stream.
#[derive(Default)]
pub struct Programs(HashMap<String, Running>);

impl Programs {
    /// Ask a program at `path`, given with its arguments on one line.
    pub fn ask(
        &mut self,
        path: &Path,
        program: &str,
        (detail, request): (f32, &str),
        patience: Duration,
    ) -> Result<Vec<u8>, String> {
        if !self.0.contains_key(program) {
            let running = start(path, program)?;
            self.0.insert(program.into(), running);
        }
        let running = self.0.get_mut(program).expect("started above");
        // A program may answer without reading what it is asked.
        let _ = running.requests.send(format!("{detail} {request}\n"));
        let mut answer = running.answers.recv_timeout(LONG.min(patience));
        if answer == Err(RecvTimeoutError::Timeout) && patience > LONG {
            let most = patience.as_secs_f64();
            eprintln!("waiting for the program `{}`, which has {most} s for an answer", program.escape_debug());
            answer = running.answers.recv_timeout(patience - LONG);
        }
        let answer = match answer {
            Ok(Ok(answer)) => Ok(answer),
            Ok(Err(e)) => Err(format!("program `{program}` {e}")),
            Err(_) => {
                let most = patience.as_secs_f64();
                Err(format!("program `{program}` gave no answer within {most} s; --program-seconds gives it more"))
            }
        };
        if answer.is_err() {
            // Dropping it ends it.
            self.0.remove(program);
        }
        answer
    }
}

/// Start a program, without a shell, in a group of its own that ends with it.
fn start(path: &Path, program: &str) -> Result<Running, String> {
    let mut command = Command::new(path);
    command.args(program.split_whitespace().skip(1)).stdin(Stdio::piped()).stdout(Stdio::piped());
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    let mut child = command.spawn().map_err(|e| format!("program `{}` cannot be started: {e}", path.display()))?;
    let (mut stdin, stdout) = (child.stdin.take().expect("piped"), child.stdout.take().expect("piped"));
    let (requests, asked) = channel::<String>();
    // A program that reads none of a long request holds up nobody else.
    std::thread::spawn(move || {
        for request in asked {
            if stdin.write_all(request.as_bytes()).and_then(|_| stdin.flush()).is_err() {
                return;
            }
        }
    });
    let (send, answers) = channel();
    std::thread::spawn(move || {
        let mut answer = Vec::new();
        let most = || (guard::memory::room() as usize / 2).min(MAX_ANSWER);
        let mut longest = most();
        for byte in BufReader::new(stdout).bytes() {
            match byte {
                Ok(0xff) => {
                    if send.send(Ok(std::mem::take(&mut answer))).is_err() {
                        return;
                    }
                    longest = most();
                }
                Ok(byte) if answer.len() < longest => answer.push(byte),
                Ok(_) => {
                    let most = guard::memory::Bytes(longest as u64);
                    let _ = send
                        .send(Err(format!("answers without end: {most}, and no byte 0377, which closes an answer")));
                    return;
                }
                Err(e) => {
                    let _ = send.send(Err(format!("cannot be read: {e}")));
                    return;
                }
            }
        }
        let _ = send.send(Err("ended before byte 0377, which closes an answer".into()));
    });
    Ok(Running { child, requests, answers })
}

impl Drop for Running {
    fn drop(&mut self) {
        #[cfg(unix)]
        // SAFETY: the group is that of the child, which has not been waited for, so that its number is still its own.
        unsafe {
            libc::kill(-(self.child.id() as i32), libc::SIGKILL);
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
