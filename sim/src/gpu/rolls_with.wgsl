// Whether contacts have rolling and spinning friction: here some have.
const ROLLS: bool = true;
