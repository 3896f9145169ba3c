#include "selftest.h"

#include <Arduino.h>
#include <avr/eeprom.h>
#include <avr/wdt.h>
#include <my1016_sensors.h>

#include "board.h"
#include "config.h"
#include "console.h"
#include "cpu.h"
#include "crc32.h"
#include "memory.h"
#include "latch.h"
#include "oscillator.h"
#include "output.h"

// The CRC of the program as it was built, written behind the linker by seal.py (all ones: nobody has). It is left out of itself.
extern "C" {
extern const uint32_t gen_seal __attribute__((externally_visible));
const uint32_t gen_seal __attribute__((used, section(".progmem.data.gen_seal"))) = 0xFFFFFFFFUL;
}

namespace selftest {

namespace {

enum Part : uint8_t { NONE, FLASH, RAM, CPU, CLOCK, SENSORS, EEPROM, VERDICT };

const uint16_t SLICE = 256;       // bytes of flash
const uint8_t SAMPLE_SLICE = 16;  // bytes of flash, and of RAM, in each sample's share of the tests that never end

const uint32_t UNSEALED = 0xFFFFFFFFUL;

// A pass over the program.
struct Sum {
    uint32_t crc;
    uint32_t next;  // address in flash
};

Part part = NONE;
bool passed;
uint32_t at_start;  // CRC of the flash
Sum asked;          // by `test`
Sum always;         // goes on and on
uint16_t ram_next;  // address of the byte that is tried next
bool bad_flash, bad_ram, bad_cpu;
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

void begin_sum(Sum *sum) {
    sum->crc = CRC32_START;
    sum->next = 0;
}

// True once it is over the whole program.
bool summed(Sum *sum, uint16_t bytes) {
    const uint32_t end = board::flash_bytes(), seal = pgm_get_far_address(gen_seal);
    for (; bytes > 0 && sum->next < end; --bytes, ++sum->next) {
        if (sum->next - seal >= sizeof gen_seal) {
            sum->crc = crc32(sum->crc, board::flash_byte(sum->next));
        }
    }
    return sum->next == end;
}

// As it stands in flash.
uint32_t sealed() {
    const uint32_t at = pgm_get_far_address(gen_seal);
    uint32_t seal = 0;
    for (uint8_t i = sizeof seal; i > 0; --i) {
        seal = seal << 8 | board::flash_byte(at + i - 1u);
    }
    return seal;
}

// The CRC that the program should have: as built, or without a seal the one at the start.
uint32_t expected() {
    const uint32_t seal = sealed();
    return seal == UNSEALED ? at_start : seal;
}

}  // namespace

void begin() {
    begin_sum(&always);
    while (!summed(&always, SLICE)) {
        wdt_reset();  // 150 KB take its 2 s
    }
    at_start = ~always.crc;
    bad_flash = at_start != expected();
    begin_sum(&always);
    ram_next = RAMSTART;
}

uint32_t crc() { return at_start; }

bool is_sealed() { return sealed() != UNSEALED; }

bool flash_is_damaged() { return bad_flash; }

bool ram_is_damaged() { return bad_ram; }

bool cpu_is_damaged() { return bad_cpu; }

void sample() {
    bad_cpu = bad_cpu || !cpu::registers_hold();
    if (summed(&always, SAMPLE_SLICE)) {
        bad_flash = bad_flash || ~always.crc != expected();
        begin_sum(&always);
    }
    for (uint8_t i = 0; i < SAMPLE_SLICE; ++i) {
        bad_ram = bad_ram || !board::ram_holds(ram_next);
        ram_next = ram_next == RAMEND ? RAMSTART : (uint16_t)(ram_next + 1);
    }
}

void start() {
    part = FLASH;
    passed = true;
    begin_sum(&asked);
    slot = 0;
    copies = 0;
}

bool work() {
    if (part == NONE || !output::takes_line()) {
        return false;
    }
    switch (part) {
        case FLASH:
            if (summed(&asked, SLICE)) {
                finding(F("flash"), ~asked.crc == expected() && !bad_flash);
                output::put_hex(~asked.crc);
                output::put(is_sealed() ? F("") : F(" not sealed"));
                end_finding(RAM);
            }
            break;
        case RAM: {
            const uint16_t untouched = board::untouched_ram();
            finding(F("ram"), untouched >= config::STACK_RESERVE && !bad_ram);
            output::put_number(untouched);
            output::put(F(" bytes untouched"));
            end_finding(CPU);
            break;
        }
        case CPU:
            finding(F("cpu"), !bad_cpu);
            output::put(F("r0..r31, SREG"));
            end_finding(CLOCK);
            break;
        case CLOCK:
            finding(F("clock"), !oscillator::clock_is_off());
            output::put_number(oscillator::took_us());
            output::put(F(" us of 16 ms"));
            end_finding(SENSORS);
            break;
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
