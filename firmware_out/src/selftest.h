// The self test: flash, RAM, sensors, EEPROM; in slices between the samples, its findings as lines on the serial line.
#ifndef SELFTEST_H
#define SELFTEST_H

#include <stdint.h>

namespace selftest {

// Sums up the program in flash, 0.4 s for 30 KB, and compares it with what was built. For setup() only: it feeds the watchdog.
void begin();

// CRC-32 of the program as it was then, without the seal.
uint32_t crc();

// Whether seal.py has written what the program should sum up to. Without it later tests compare with the start.
bool is_sealed();

// Once a sample: the CPU's registers, and a few bytes of flash and RAM, round and round, whatever else is tested. What was found stays found.
void sample();
bool flash_is_damaged();
bool ram_is_damaged();
bool cpu_is_damaged();

// The test that somebody asks for.
void start();

// One slice, a few milliseconds. False if no test runs.
bool work();

}  // namespace selftest

#endif
