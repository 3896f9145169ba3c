#include "mega.h"

#include "analog.h"
#include "counter.h"
#include "eeprom.h"
#include "encoder.h"
#include "mailbox.h"
#include "max6675.h"
#include "registers.h"
#include "pins.h"
#include "run.h"
#include "uart.h"
#include "wave.h"

#include <simavr/sim_elf.h>

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MCUSR 0x54 /* data address */
#define PORF 1u
#define DATA_SPACE 0x10000u    /* what a 16-bit address reaches */
#define FLASH_SPACE 0x2000004u /* what EIND and RAMPZ reach: 2^24 words, and an opcode's second word */

/* In the order in which they are asked. */
static const struct part *const parts[] = {
	&mega_pins_part,    &mega_uart_part,    &mega_mailbox_part, &mega_chips_part, &mega_register_chips_part, &mega_counter_part,
	&mega_encoder_part, &mega_waves_part,   &mega_eeprom_part,  &mega_analog_part,  NULL,
};

static struct gen_mega *of(const avr_t *avr)
{
	return avr->custom.data;
}

/* ---- what simavr tells ---------------------------------------------------------------------------------------- */

/* simavr reports an illegal opcode through its log only, and goes on. */
static void logger(avr_t *avr, const int level, const char *format, va_list arguments)
{
	if (level > LOG_ERROR || !avr || !avr->custom.data)
		return;
	struct gen_mega *mega = of(avr);
	int fatal = strstr(format, "CORE:") != NULL;
	if (!fatal || mega->crashed || mega->astray)
		return;
	vsnprintf(mega->message, sizeof mega->message, format, arguments);
	mega->crashed = 1;
	mega_stop(mega, STOP_CRASHED);
}

/* Idle time passes in the cycle counter alone. simavr asks for it piece by piece, and again at every event. */
static void count_sleep(avr_t *avr, avr_cycle_count_t cycles)
{
	struct gen_mega *mega = of(avr);
	avr_cycle_count_t awake = avr->cycle - mega->woke;
	if (awake > mega->longest_awake)
		mega->longest_awake = awake;
	mega->asleep += cycles;
	mega->woke = avr->cycle + cycles;
}

static void on_reset(avr_t *avr) /* simavr has dropped its timers, and goes on to reset its peripherals */
{
	struct gen_mega *mega = of(avr);
	if (mega->core_reset)
		mega->core_reset(avr);
	mega->resets++;
	mega->timers_lost = 1;
	for (const struct part *const *part = parts; *part; part++)
		if ((*part)->reset)
			(*part)->reset(mega);
}

/* ---- opening, closing, resetting ------------------------------------------------------------------------------ */

static void free_firmware(elf_firmware_t *firmware)
{
	free(firmware->flash);
	free(firmware->eeprom);
	free(firmware->fuse);
	free(firmware->lockbits);
	for (uint32_t i = 0; i < firmware->symbolcount; i++)
		free(firmware->symbol[i]);
	free(firmware->symbol);
}

uint32_t gen_mega_abi(void)
{
	return GEN_MEGA_ABI;
}

void gen_mega_close(struct gen_mega *mega)
{
	if (!mega)
		return;
	if (mega->avr) {
		mega->avr->custom.deinit = NULL;
		avr_terminate(mega->avr);
		free(mega->avr);
	}
	for (const struct part *const *part = parts; *part; part++)
		(*part)->close(mega);
	free(mega);
}

static int widen(uint8_t **memory, size_t held, size_t wanted)
{
	uint8_t *wide = calloc(1, wanted); /* pages that nobody touches cost nothing */
	if (!wide)
		return -1;
	memcpy(wide, *memory, held);
	free(*memory);
	*memory = wide;
	return 0;
}

/* simavr 1.6 reports an access behind the end of a memory, and then does it all the same. A firmware that goes astray
 * must not write into this process's own heap: both memories get room for every address that the chip can form.
 */
static int widen_memories(avr_t *avr)
{
	return widen(&avr->data, (size_t)avr->ramend + 1, DATA_SPACE) ||
	       widen(&avr->flash, (size_t)avr->flashend + 3, FLASH_SPACE);
}

/* 0 when it worked; else the message tells why not. */
static int load_firmware(struct gen_mega *mega, elf_firmware_t *firmware, const char *mcu)
{
	mega->avr = avr_make_mcu_by_name(mcu);
	if (!mega->avr) {
		mega_note(mega, "this libsimavr has no %s", mcu);
		return -1;
	}
	avr_init(mega->avr);
	if (widen_memories(mega->avr) != 0) {
		mega_note(mega, "out of memory");
		return -1;
	}
	mega->avr->log = LOG_ERROR;
	mega->avr->custom.data = mega;
	snprintf(firmware->mmcu, sizeof firmware->mmcu, "%s", mcu);
	firmware->frequency = FREQUENCY_HZ;
	avr_load_firmware(mega->avr, firmware);
	mega->avr->frequency = FREQUENCY_HZ;
	return 0;
}

int gen_mega_watchdog_hz(struct gen_mega *mega, uint32_t hz)
{
	if (hz == 0)
		return -1;
	/* simavr takes the watchdog's time from what it takes for the clock; nothing else here does once it runs. */
	mega->avr->frequency = (uint32_t)((uint64_t)FREQUENCY_HZ * 128000 / hz);
	return 0;
}

void gen_mega_astray(struct gen_mega *mega)
{
	mega->astray = 1;
	mega->avr->codeend = mega->avr->flashend; /* the program counter runs on through flash that nobody wrote */
}

static void attach_parts(struct gen_mega *mega)
{
	mega->parts = parts;
	for (const struct part *const *part = parts; *part; part++)
		if ((*part)->attach(mega) != 0) {
			mega_note(mega, "out of memory");
			return;
		}
	mega->avr->sleep = count_sleep;
	mega->core_reset = mega->avr->reset;
	mega->avr->reset = on_reset;
	mega->avr->data[MCUSR] = PORF; /* the power has just come on */
	mega->timers_lost = 1;
}

struct gen_mega *gen_mega_open(const char *elf, const char *mcu)
{
	struct gen_mega *mega = calloc(1, sizeof *mega);
	if (!mega)
		return NULL;
	avr_global_logger_set(logger);
	elf_firmware_t firmware;
	memset(&firmware, 0, sizeof firmware);
	if (elf_read_firmware(elf, &firmware) != 0) {
		mega_note(mega, "simavr cannot read the ELF file");
		return mega;
	}
	int failed = load_firmware(mega, &firmware, mcu);
	free_firmware(&firmware);
	if (!failed)
		attach_parts(mega);
	return mega;
}

const char *gen_mega_message(const struct gen_mega *mega)
{
	return mega->message;
}

static uint32_t noise(uint32_t *state) /* xorshift32, G. Marsaglia 2003 */
{
	*state ^= *state << 13;
	*state ^= *state >> 17;
	*state ^= *state << 5;
	return *state;
}

static void fill_with_noise(avr_t *avr, uint32_t *state)
{
	for (uint32_t address = avr->ioend + 1u; address <= avr->ramend; address++)
		avr->data[address] = (uint8_t)(noise(state) >> 11);
}

void gen_mega_reset(struct gen_mega *mega, uint8_t mcusr, int power_lost, uint64_t off, uint32_t seed)
{
	avr_t *avr = mega->avr;
	uint32_t state = seed ? seed : 1;
	if (power_lost) {
		uint32_t some = noise(&state);
		for (const struct part *const *part = parts; *part; part++)
			if ((*part)->cut)
				(*part)->cut(mega, some);
	}
	avr->cycle += off;
	avr_reset(avr);
	if (power_lost) {
		fill_with_noise(avr, &state);
		for (const struct part *const *part = parts; *part; part++)
			if ((*part)->restored)
				(*part)->restored(mega);
	}
	avr->data[MCUSR] = mcusr;
	mega->resume = cpu_Running;
}

int gen_mega_boot_loader(struct gen_mega *mega, uint32_t address, const uint8_t *program, uint32_t size)
{
	avr_t *avr = mega->avr;
	if (address > avr->flashend || size > avr->flashend + 1 - address)
		return -1;
	memcpy(avr->flash + address, program, size);
	avr->codeend = avr->flashend;
	avr->reset_pc = address; /* as with the fuse BOOTRST */
	avr->pc = address;
	return 0;
}

/* ---- state ---------------------------------------------------------------------------------------------------- */

uint64_t gen_mega_cycle(const struct gen_mega *mega)
{
	return mega->avr->cycle;
}

uint64_t gen_mega_asleep(const struct gen_mega *mega)
{
	return mega->asleep;
}

uint64_t gen_mega_longest_awake(struct gen_mega *mega)
{
	avr_cycle_count_t longest = mega->longest_awake;
	mega->longest_awake = 0;
	return longest;
}

uint32_t gen_mega_pc(const struct gen_mega *mega)
{
	return mega->avr->pc;
}

uint16_t gen_mega_sp(const struct gen_mega *mega)
{
	return (uint16_t)(mega->avr->data[R_SPL] | mega->avr->data[R_SPH] << 8);
}

uint16_t gen_mega_ramend(const struct gen_mega *mega)
{
	return mega->avr->ramend;
}

uint32_t gen_mega_resets(const struct gen_mega *mega)
{
	return mega->resets;
}

int gen_mega_peek(const struct gen_mega *mega, uint32_t address, uint32_t count, uint8_t *to)
{
	if (address > mega->avr->ramend || count > mega->avr->ramend + 1u - address)
		return -1;
	memcpy(to, mega->avr->data + address, count);
	return 0;
}

int gen_mega_poke(struct gen_mega *mega, uint32_t address, uint32_t count, const uint8_t *from)
{
	if (address > mega->avr->ramend || count > mega->avr->ramend + 1u - address)
		return -1;
	memcpy(mega->avr->data + address, from, count);
	return 0;
}

/* ---- running -------------------------------------------------------------------------------------------------- */

int gen_mega_run(struct gen_mega *mega, uint64_t limit, const uint8_t *pattern, size_t length)
{
	if (mega_uart_await(mega, pattern, length) != 0)
		return STOP_PROTOCOL;
	int reason = mega_run(mega, limit);
	mega_uart_await(mega, NULL, 0);
	return reason;
}

int gen_mega_run_to(struct gen_mega *mega, uint64_t limit, uint32_t place)
{
	return mega_run_to(mega, limit, place);
}
