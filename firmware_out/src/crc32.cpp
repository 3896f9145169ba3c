#include "crc32.h"

#include <avr/pgmspace.h>

// Remainders of the 16 half bytes; polynomial 0xEDB88320 (reflected).
static const uint32_t remainders[16] PROGMEM = {
    0x00000000UL, 0x1DB71064UL, 0x3B6E20C8UL, 0x26D930ACUL, 0x76DC4190UL, 0x6B6B51F4UL, 0x4DB26158UL, 0x5005713CUL,
    0xEDB88320UL, 0xF00F9344UL, 0xD6D6A3E8UL, 0xCB61B38CUL, 0x9B64C2B0UL, 0x86D3D2D4UL, 0xA00AE278UL, 0xBDBDF21CUL};

uint32_t crc32(uint32_t crc, uint8_t byte) {
    crc ^= byte;
    crc = (crc >> 4) ^ pgm_read_dword(&remainders[crc & 0x0F]);
    return (crc >> 4) ^ pgm_read_dword(&remainders[crc & 0x0F]);
}

uint32_t crc32_of(const void *record, uint16_t bytes) {
    const uint8_t *byte = static_cast<const uint8_t *>(record);
    uint32_t crc = CRC32_START;
    for (; bytes > 0; --bytes) {
        crc = crc32(crc, *byte++);
    }
    return ~crc;
}
