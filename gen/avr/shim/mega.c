/* The chip itself: opening, resetting, running, stopping, memory. */
#include "mega.h"

#include <simavr/sim_elf.h>
#include <simavr/avr_extint.h>

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MCUSR 0x54 /* data address */
#define PORF 1u
#define EXTERNAL_INTERRUPTS 8
#define RAM_START 0x200
#define DATA_SPACE 0x10000u    /* what a 16-bit address reaches */
#define FLASH_SPACE 0x2000004u /* what EIND and RAMPZ reach: 2^24 words, and an opcode's second word */

/* ---- stopping ------------------------------------------------------------------------------------------------- */

static struct gen_mega *of(const avr_t *avr)
{
	return avr->custom.data;
}

void mega_stop(struct gen_mega *mega, int reason)
{
	if (mega->stopped)
		return;
	mega->stopped = 1;
	mega->stop = reason;
	if (mega->avr->state == cpu_Running || mega->avr->state == cpu_Sleeping) {
		mega->resume = mega->avr->state;
		mega->avr->state = cpu_Stopped; /* leaves avr_run_one's inner loop after this instruction */
	}
}

void mega_note(struct gen_mega *mega, const char *format, ...)
{
	va_list arguments;
	va_start(arguments, format);
	vsnprintf(mega->message, sizeof mega->message, format, arguments);
	va_end(arguments);
}

/* simavr reports an illegal opcode through its log only, and goes on. */
static void logger(avr_t *avr, const int level, const char *format, va_list arguments)
{
	if (level > LOG_ERROR || !avr || !avr->custom.data)
		return;
	struct gen_mega *mega = of(avr);
	int fatal = strstr(format, "CORE:") != NULL;
	if (!fatal || mega->crashed)
		return;
	vsnprintf(mega->message, sizeof mega->message, format, arguments);
	mega->crashed = 1;
	mega_stop(mega, STOP_CRASHED);
}

static avr_cycle_count_t at_limit(avr_t *avr, avr_cycle_count_t when, void *parameter)
{
	(void)avr;
	(void)when;
	mega_stop(parameter, STOP_LIMIT);
	return 0;
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

/* ---- opening, resetting, closing ------------------------------------------------------------------------------ */

static void on_reset(avr_t *avr) /* simavr has dropped its timers, and goes on to reset its peripherals */
{
	struct gen_mega *mega = of(avr);
	if (mega->core_reset)
		mega->core_reset(avr);
	mega->resets++;
	mega->timers_lost = 1;
	mega->records.stepping = 0;
	mega->uart.full = 0;
	mega_chips_reset(mega, 0);
	mega_counter_reset(mega);
}

/* simavr polls a low pin at every cycle once the pin has fallen in level mode, the mode after a reset. */
static void stop_polling_levels(struct gen_mega *mega)
{
	for (uint8_t i = 0; i < EXTERNAL_INTERRUPTS; i++)
		avr_extint_set_strict_lvl_trig(mega->avr, i, 0);
}

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
	mega_uart_close(mega);
	mega_pins_close(mega);
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

/* NULL only when memory is short; else a handle, whose message tells what went wrong, if anything did. */
struct gen_mega *gen_mega_open(const char *elf)
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
	mega->avr = avr_make_mcu_by_name("atmega2560");
	if (!mega->avr) {
		mega_note(mega, "this libsimavr has no atmega2560");
		free_firmware(&firmware);
		return mega;
	}
	avr_init(mega->avr);
	if (widen_memories(mega->avr) != 0) {
		mega_note(mega, "out of memory");
		free_firmware(&firmware);
		return mega;
	}
	mega->avr->log = LOG_ERROR;
	mega->avr->custom.data = mega;
	strcpy(firmware.mmcu, "atmega2560");
	firmware.frequency = FREQUENCY_HZ;
	avr_load_firmware(mega->avr, &firmware);
	free_firmware(&firmware);
	mega->avr->frequency = FREQUENCY_HZ;
	mega->avr->sleep = count_sleep;
	mega->core_reset = mega->avr->reset;
	mega->avr->reset = on_reset;
	mega->avr->data[MCUSR] = PORF; /* the power has just come on */
	mega->timers_lost = 1;
	mega_uart_attach(mega);
	mega_mailbox_attach(mega);
	mega_pins_attach(mega);
	mega_eeprom_attach(mega);
	stop_polling_levels(mega);
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

/* Reset the chip. MCUSR tells the firmware why: bit 0 power-on, 1 external, 2 brown-out, 3 watchdog. With power_lost
 * the SRAM holds noise afterwards, an EEPROM write under way is left half done, and off cycles pass before the reset.
 */
void gen_mega_reset(struct gen_mega *mega, uint8_t mcusr, int power_lost, uint64_t off, uint32_t seed)
{
	avr_t *avr = mega->avr;
	uint32_t state = seed ? seed : 1;
	if (power_lost)
		mega_eeprom_cut(mega, noise(&state));
	avr->cycle += off;
	avr_reset(avr);
	if (power_lost) {
		for (uint32_t address = RAM_START; address <= avr->ramend; address++)
			avr->data[address] = (uint8_t)(noise(&state) >> 11);
		mega_chips_reset(mega, 1);
		mega->uart.queue_head = mega->uart.queue_length;
	}
	avr->data[MCUSR] = mcusr;
	mega->resume = cpu_Running;
}

/* ---- state ---------------------------------------------------------------------------------------------------- */

uint64_t gen_mega_cycle(const struct gen_mega *mega)
{
	return mega->avr->cycle;
}

uint64_t gen_mega_asleep(const struct gen_mega *mega) /* cycles spent in a sleep mode */
{
	return mega->asleep;
}

/* The longest stretch without sleep, in cycles, since it was asked for last. */
uint64_t gen_mega_longest_awake(struct gen_mega *mega)
{
	avr_cycle_count_t longest = mega->longest_awake;
	mega->longest_awake = 0;
	return longest;
}

uint32_t gen_mega_pc(const struct gen_mega *mega) /* in bytes */
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

/* Peek and poke see memory as it lies, without the side effects of an I/O register. 0 when it worked. */
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

static void rearm(struct gen_mega *mega) /* what a reset, or a first start, takes */
{
	mega->timers_lost = 0;
	stop_polling_levels(mega);
	mega_pins_reset(mega);
	mega_encoder_rearm(mega);
	mega_waves_rearm(mega);
	mega_eeprom_rearm(mega);
}

static void arm(struct gen_mega *mega)
{
	avr_cycle_count_t now = mega->avr->cycle;
	if (mega->timers_lost)
		rearm(mega);
	avr_cycle_timer_cancel(mega->avr, at_limit, mega);
	avr_cycle_timer_register(mega->avr, mega->limit > now ? mega->limit - now : 1, at_limit, mega);
	mega_uart_rearm(mega);
}

static int run(struct gen_mega *mega, uint64_t limit, int64_t place)
{
	avr_t *avr = mega->avr;
	if (mega->crashed)
		return STOP_CRASHED;
	if (avr->state == cpu_Done)
		return STOP_ENDED;
	if (avr->cycle >= limit)
		return STOP_LIMIT;
	if (avr->state == cpu_Stopped) {
		/* An interrupt that was raised in the moment of the stop found nobody asleep to wake. */
		int woken = mega->resume == cpu_Sleeping && avr_has_pending_interrupts(avr);
		avr->state = woken ? cpu_Running : mega->resume;
	}
	mega->limit = limit;
	mega->stopped = 0;
	arm(mega);
	while (!mega->stopped) {
		int state = avr_run(avr);
		if (mega->stopped)
			break;
		if (state == cpu_Crashed) {
			if (!mega->crashed)
				mega_note(mega, "the firmware jumped to an address outside its flash");
			mega->crashed = 1;
			return STOP_CRASHED;
		}
		if (state == cpu_Done)
			return STOP_ENDED;
		if (mega->timers_lost)
			arm(mega);
		if (place >= 0 && avr->pc == (avr_flashaddr_t)place)
			mega_stop(mega, STOP_PLACE);
	}
	avr_cycle_timer_cancel(avr, at_limit, mega);
	return mega->stop;
}

int mega_run(struct gen_mega *mega, uint64_t limit)
{
	return run(mega, limit, -1);
}

/* Run until the cycle counter reaches limit, or until length bytes of pattern have left UART0 (none when 0).
 * Bytes sent before gen_mega_uart_forget() or up to the last match do not count. */
int gen_mega_run(struct gen_mega *mega, uint64_t limit, const uint8_t *pattern, size_t length)
{
	if (length > PATTERN_SIZE) {
		mega_note(mega, "the awaited pattern is longer than %d bytes", PATTERN_SIZE);
		return STOP_PROTOCOL;
	}
	if (length)
		memcpy(mega->uart.pattern, pattern, length);
	mega->uart.pattern_length = length;
	int reason = mega_run(mega, limit);
	mega->uart.pattern_length = 0;
	return reason;
}

/* Run, instruction by instruction, until the program counter (in bytes) stands at a place. */
int gen_mega_run_to(struct gen_mega *mega, uint64_t limit, uint32_t place)
{
	avr_cycle_count_t kept = mega->avr->run_cycle_limit;
	mega->avr->run_cycle_limit = 1;
	mega->avr->run_cycle_count = 1;
	int reason = run(mega, limit, place);
	mega->avr->run_cycle_limit = kept;
	return reason;
}
