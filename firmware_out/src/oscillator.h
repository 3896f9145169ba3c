// The clock against the watchdog's oscillator: two that know nothing of each other.
#ifndef OSCILLATOR_H
#define OSCILLATOR_H

#include <stdint.h>

namespace oscillator {

// Once a sample, after the watchdog was fed: every 10 s it lets the watchdog ring after 16 ms instead of resetting, and takes the time.
void sample();

// Whether the watchdog must not be fed: it would begin anew.
bool measures();

// Whether the last two measurements were off by more than the oscillator's own tolerance.
bool clock_is_off();

// The last one, in microseconds by the clock; 0 before the first.
uint16_t took_us();

}  // namespace oscillator

#endif
