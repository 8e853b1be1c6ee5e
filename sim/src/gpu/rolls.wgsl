// Whether contacts have rolling and spinning friction: here none has.
const ROLLS: bool = false;
