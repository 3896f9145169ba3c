#include "guard.h"

#include <my1016_protection.h>
#include <my1016_sensors.h>

#include "commands.h"
#include "commissioned.h"
#include "commissioning.h"
#include "config.h"
#include "device.h"
#include "drive.h"
#include "encoder.h"
#include "latch.h"
#include "memory.h"
#include "oscillator.h"
#include "selftest.h"

using device::now;

namespace guard {

namespace {

uint32_t unseen = config::UNSEEN;  // thermocouples that no sample was believed of since the start

uint32_t lost() {
    uint32_t channels = 0;
    for (uint8_t channel = 0; channel < MY1016_SENSORS; ++channel) {
        if (my1016_sensors_code(channel) != MY1016_SAMPLE_OK) {
            channels |= (uint32_t)1 << channel;
        }
    }
    return channels;
}

uint16_t bit(bool holds, uint16_t of) { return holds ? of : 0; }

uint16_t of_the_encoder() {
    const bool known = !encoder::noisy();
    return (uint16_t)(bit(encoder::stalled(), MY1016_DEVICE_STALL) |
                      bit(known && encoder::rpm() > config::OVERSPEED_RPM, MY1016_DEVICE_OVERSPEED) |
                      bit(known && drive::pwm() == 0 && encoder::rpm() > config::TURNING_RPM, MY1016_DEVICE_TURNING_WITHOUT_COMMAND));
}

uint16_t of_the_device() {
    uint16_t causes = bit(now.flags & device::LATE, MY1016_DEVICE_LATE_LOOP);
    causes |= of_the_encoder();
    causes |= bit(unseen, MY1016_DEVICE_SENSOR_UNSEEN);
    causes |= bit(selftest::flash_is_damaged(), MY1016_DEVICE_FLASH_CHECK);
    causes |= bit(selftest::ram_is_damaged(), MY1016_DEVICE_RAM_CHECK);
    causes |= bit(selftest::cpu_is_damaged(), MY1016_DEVICE_CPU_CHECK);
    causes |= bit(oscillator::clock_is_off(), MY1016_DEVICE_CLOCK_CHECK);
    causes |= bit(memory::failed() || latch::failed(), MY1016_DEVICE_EEPROM_CHECK);
    causes |= bit(!commissioned::passed() && !commissioning::drives(), MY1016_DEVICE_NOT_COMMISSIONED);
    return causes;
}

}  // namespace

uint8_t sample() {
    my1016_Conditions conditions = my1016_Conditions();
    conditions.lost = lost();
    unseen &= conditions.lost;
    conditions.alarms = my1016_alarms();
    conditions.device = of_the_device();
    my1016_protection_step(&conditions, &now.sample);
    // Beside the table: what is wrong with the program may be what evaluates the table.
    const bool refused = selftest::flash_is_damaged();
    if (refused) {
        return 0;
    }
    return my1016_protection_most_pwm();
}

}  // namespace guard
