//! `Procedural "RunProgram"`: programs that are told a level of detail and a request on a line, and answer with RIB that ends in
//! byte 0377 (RISpec 5.8). A program is started once and asked again and again.

use std::collections::HashMap;
use std::io::{BufReader, Read, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

/// How long an answer may take.
const PATIENCE: Duration = Duration::from_secs(120);
/// Maximum length of an answer, bytes.
const MAX_ANSWER: usize = 4 << 30;

struct Running {
    child: Child,
    stdin: ChildStdin,
    answers: Receiver<Result<Vec<u8>, String>>,
}

/// The programs of a stream.
#[derive(Default)]
pub struct Programs(HashMap<String, Running>);

impl Programs {
    /// Ask a program, given with its arguments on one line.
    pub fn ask(&mut self, program: &str, detail: f32, request: &str) -> Result<Vec<u8>, String> {
        if !self.0.contains_key(program) {
            let running = start(program)?;
            self.0.insert(program.into(), running);
        }
        let running = self.0.get_mut(program).expect("started above");
        let asked = writeln!(running.stdin, "{detail} {request}").and_then(|_| running.stdin.flush());
        // A program may answer without reading what it is asked.
        let answer = match (running.answers.recv_timeout(PATIENCE), asked) {
            (Ok(Ok(answer)), _) => Ok(answer),
            (Ok(Err(e)), _) => Err(format!("program `{program}` {e}")),
            (Err(_), Err(e)) => Err(format!("program `{program}` takes no request: {e}")),
            (Err(_), Ok(())) => Err(format!("program `{program}` gave no answer within {} s", PATIENCE.as_secs())),
        };
        if answer.is_err() {
            // Dropping it ends it.
            self.0.remove(program);
        }
        answer
    }
}

fn start(program: &str) -> Result<Running, String> {
    let mut words = program.split_whitespace();
    let name = words.next().ok_or("RunProgram needs a program")?;
    let mut child = Command::new(name)
        .args(words)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|e| format!("program `{name}` cannot be started: {e}"))?;
    let (stdin, stdout) = (child.stdin.take().expect("piped"), child.stdout.take().expect("piped"));
    let (send, answers) = channel();
    std::thread::spawn(move || {
        let mut answer = Vec::new();
        for byte in BufReader::new(stdout).bytes() {
            match byte {
                Ok(0xff) => {
                    if send.send(Ok(std::mem::take(&mut answer))).is_err() {
                        return;
                    }
                }
                Ok(byte) if answer.len() < MAX_ANSWER => answer.push(byte),
                Ok(_) => {
                    let _ = send.send(Err("answers without end".into()));
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
    Ok(Running { child, stdin, answers })
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
