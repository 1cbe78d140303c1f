// Arithmetic on pairs of half floats, which devices do in one instruction.

// Reciprocal of normal half floats above 2^-14, within 2^-10: a guess by the bits (the exponent is negated), and two steps of Newton's method. The special
// function unit would take eight times as long.
f16vec2 reciprocal(f16vec2 x) {
    f16vec2 y = unpackFloat2x16(0x77847784u - packFloat2x16(x));
    y *= 2.0hf - x * y;
    return y * (2.0hf - x * y);
}
