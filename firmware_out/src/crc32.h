// CRC-32 as in Ethernet, zip and Python's zlib.crc32.
#ifndef CRC32_H
#define CRC32_H

#include <stdint.h>

const uint32_t CRC32_START = 0xFFFFFFFFUL;  // the result is the complement of what the last byte leaves

// Takes one byte more; some 200 cycles with what fetches it.
uint32_t crc32(uint32_t crc, uint8_t byte);

// Of a record's first bytes: all before the place where its own CRC stands.
uint32_t crc32_of(const void *record, uint16_t bytes);

#endif
