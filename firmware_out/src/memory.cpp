#include "memory.h"

#include <avr/eeprom.h>
#include <stddef.h>

#include "config.h"
#include "crc32.h"
#include "snapshot.h"
#include "writing.h"

namespace memory {

namespace {

struct Copy {
    uint32_t identity;
    uint32_t number;  // one more with every copy: the highest is the newest
    snapshot::Snapshot snapshot;
    uint32_t crc;  // of all before it
};
static_assert(sizeof(Copy) == config::COPY_BYTES, "slots were counted for another size");

struct Firmware {
    uint32_t crc;
    uint32_t complement;
};

Copy copy;          // being written, or the one found at the start
Firmware firmware;  // of this program

Writing writing;

uint16_t slot;  // of the newest copy
uint32_t newest;  // its number; 0: none
uint32_t samples_to_copy = config::COPY_SAMPLES;
bool checking;  // a copy has been written and is to be read again
bool failure;
bool new_firmware;

uint16_t address(uint16_t of_slot) { return (uint16_t)(of_slot * sizeof(Copy)); }

uint8_t *place(uint16_t at) { return reinterpret_cast<uint8_t *>(at); }

uint32_t crc_of(const Copy &of) { return crc32_of(&of, offsetof(Copy, crc)); }

uint32_t number_in(uint16_t of_slot) {
    const uint16_t at = address(of_slot);
    const bool ours = eeprom_read_dword(reinterpret_cast<const uint32_t *>(at)) == config::COPY_IDENTITY;
    return ours ? eeprom_read_dword(reinterpret_cast<const uint32_t *>(at + offsetof(Copy, number))) : 0;
}

bool fetch(uint16_t of_slot) {
    eeprom_read_block(&copy, place(address(of_slot)), sizeof copy);
    return copy.identity == config::COPY_IDENTITY && copy.number != 0 && copy.crc == crc_of(copy);
}

void make_copy() {
    slot = (uint16_t)(slot + 1 == config::COPY_SLOTS ? 0 : slot + 1);
    copy.identity = config::COPY_IDENTITY;
    copy.number = newest + 1;
    snapshot::take(&copy.snapshot);
    copy.crc = crc_of(copy);
    writing.begin(&copy, sizeof copy, address(slot));
    checking = true;
}

}  // namespace

void begin(uint32_t crc) {
    // From the highest number down to the first one whose CRC is right.
    for (uint32_t below = UINT32_MAX;;) {
        newest = 0;
        for (uint16_t i = 0; i < config::COPY_SLOTS; ++i) {
            const uint32_t number = number_in(i);
            if (number < below && number > newest) {
                newest = number;
                slot = i;
            }
        }
        if (newest == 0 || fetch(slot)) {
            break;
        }
        below = newest;
    }
    eeprom_read_block(&firmware, place(config::FIRMWARE_AT), sizeof firmware);
    new_firmware = firmware.crc != crc || firmware.complement != ~crc;
    if (new_firmware) {
        firmware.crc = crc;
        firmware.complement = ~crc;
        writing.begin(&firmware, sizeof firmware, config::FIRMWARE_AT);
    }
}

bool resume() {
    if (newest == 0 || !snapshot::is_true(copy.snapshot)) {
        return false;
    }
    snapshot::put(copy.snapshot);
    return true;
}

void update() {
    if (samples_to_copy > 0) {
        --samples_to_copy;
    }
    if (!eeprom_is_ready()) {
        return;
    }
    if (!writing.done()) {
        writing.go_on();
    } else if (checking) {
        checking = false;
        const uint32_t number = copy.number;
        failure = !fetch(slot) || copy.number != number;
        newest = number;  // taken even so: two slots with one number would hide the sound one behind the other
    } else if (samples_to_copy == 0) {
        samples_to_copy = config::COPY_SAMPLES;
        make_copy();
    }
}

bool failed() { return failure; }

bool firmware_is_new() { return new_firmware; }

bool valid(uint16_t of_slot) {
    uint32_t crc = CRC32_START;
    const uint16_t at = address(of_slot);
    for (uint16_t i = 0; i < offsetof(Copy, crc); ++i) {
        crc = crc32(crc, eeprom_read_byte(place(at + i)));
    }
    return number_in(of_slot) != 0 && eeprom_read_dword(reinterpret_cast<const uint32_t *>(at + offsetof(Copy, crc))) == ~crc;
}

}  // namespace memory
