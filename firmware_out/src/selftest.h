// The self test: flash, RAM, sensors, EEPROM; in slices between the samples, its findings as lines on the serial line.
#ifndef SELFTEST_H
#define SELFTEST_H

#include <stdint.h>

namespace selftest {

// CRC-32 of the program in flash; 0.4 s for 30 KB. For setup() only: it feeds the watchdog.
uint32_t flash_crc();

// Keeps flash_crc() as what later tests compare with.
void begin(uint32_t crc);
uint32_t crc();

void start();

// One slice, a few milliseconds. False if no test runs.
bool work();

}  // namespace selftest

#endif
