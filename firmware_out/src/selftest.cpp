#include "selftest.h"

#include <Arduino.h>
#include <avr/eeprom.h>
#include <avr/wdt.h>
#include <my1016_sensors.h>

#include "board.h"
#include "config.h"
#include "console.h"
#include "crc32.h"
#include "memory.h"
#include "latch.h"
#include "output.h"

namespace selftest {

namespace {

enum Part : uint8_t { NONE, FLASH, RAM, SENSORS, EEPROM, VERDICT };

const uint16_t SLICE = 256;  // bytes of flash

Part part = NONE;
bool passed;
uint32_t at_start;  // CRC of the flash
uint32_t running;
uint32_t next;  // address in flash
uint16_t slot;
uint16_t copies;

void finding(const __FlashStringHelper *what, bool good) {
    console::begin_event(F("test "));
    output::put(what);
    output::put(good ? F(" ok ") : F(" FAILED "));
    passed = passed && good;
}

void end_finding(Part following) {
    output::end_line();
    part = following;
}

bool flash_done() {
    const uint32_t end = board::flash_bytes();
    for (uint16_t i = 0; i < SLICE && next < end; ++i) {
        running = crc32(running, board::flash_byte(next++));
    }
    return next == end;
}

}  // namespace

uint32_t flash_crc() {
    next = 0;
    running = CRC32_START;
    while (!flash_done()) {
        wdt_reset();  // 150 KB take its 2 s
    }
    return ~running;
}

void begin(uint32_t crc) { at_start = crc; }

uint32_t crc() { return at_start; }

void start() {
    part = FLASH;
    passed = true;
    next = 0;
    running = CRC32_START;
    slot = 0;
    copies = 0;
}

bool work() {
    if (part == NONE || !output::takes_line()) {
        return false;
    }
    switch (part) {
        case FLASH:
            if (flash_done()) {
                finding(F("flash"), ~running == at_start);
                output::put_hex(~running);
                end_finding(RAM);
            }
            break;
        case RAM: {
            const uint16_t untouched = board::untouched_ram();
            finding(F("ram"), untouched >= config::STACK_RESERVE);
            output::put_number(untouched);
            output::put(F(" bytes untouched"));
            end_finding(SENSORS);
            break;
        }
        case SENSORS: {
            bool good = true;
            for (uint8_t channel = 0; channel < MY1016_SENSORS; ++channel) {
                good = good && my1016_sensors_code(channel) == MY1016_SAMPLE_OK;
            }
            finding(F("sensors"), good);
            console::put_codes();
            end_finding(EEPROM);
            break;
        }
        case EEPROM:
            if (!eeprom_is_ready()) {
                return false;
            }
            copies = (uint16_t)(copies + memory::valid(slot));
            if (++slot == config::COPY_SLOTS) {
                finding(F("eeprom"), !memory::failed() && !latch::failed());
                output::put_number(copies);
                output::put(F(" copies"));
                end_finding(VERDICT);
            }
            break;
        default:
            console::begin_event(passed ? F("test passed") : F("test FAILED"));
            end_finding(NONE);
            break;
    }
    return true;
}

}  // namespace selftest
