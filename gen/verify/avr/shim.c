/* A small C face on libsimavr for simulator.py: one opaque handle, plain integers and buffers.
 *
 * No struct of simavr crosses this border, so Python maps nothing of it. Nothing here prints or exits: a fault leaves
 * a message in the handle and a status that Python turns into an exception.
 *
 * Where things that come later belong: a device at the pins (button, MAX6675) is a file-local struct held in gen_mega,
 * attached in attach_devices() with avr_irq_register_notify() on AVR_IOCTL_IOPORT_GETIRQ(port) and driven with
 * avr_raise_irq(); if it uses cycle timers it must arm them again in on_reset(), because a watchdog reset drops all
 * of them. EEPROM contents go through avr_ioctl(AVR_IOCTL_EEPROM_GET / _SET). New functions are added at the end and
 * GEN_MEGA_ABI is raised.
 */
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <simavr/avr_uart.h>

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define GEN_MEGA_ABI 1
#define FREQUENCY_HZ 16000000u
#define GPIOR0 0x3e /* data address */
#define MESSAGE_SIZE 256
#define PATTERN_SIZE 256
#define UART_KEEP 65536u

/* Why a run ended; simulator.py holds the same numbers. */
enum gen_stop {
	STOP_LIMIT = 0,   /* the cycle limit */
	STOP_PATTERN = 1, /* the awaited bytes left UART0 */
	STOP_ENDED = 2,   /* the firmware executed cli; sleep */
	STOP_CRASHED = 3, /* illegal opcode, address or jump: see the message */
	STOP_RECORDS = 4, /* every record is done */
	STOP_PROTOCOL = 5 /* the firmware broke the mailbox protocol: see the message */
};

struct records {
	const uint8_t *in;
	uint8_t *out;
	uint32_t *cycles;
	uint32_t in_size, out_size, count, next;
	uint16_t in_address, out_address;
	int active;  /* a run_records call is under way */
	int stepping; /* between mark 1 and mark 2 */
	avr_cycle_count_t start;
};

struct uart {
	avr_irq_t *input;
	int full; /* simavr said XOFF */
	uint8_t *captured;
	size_t captured_length, captured_capacity, taken;
	uint8_t *queue;
	size_t queue_length, queue_head;
	uint64_t byte_cycles; /* spacing of the bytes that go in */
	uint8_t pattern[PATTERN_SIZE];
	size_t pattern_length;
	size_t seen_from; /* the pattern may not reach back before this place in captured */
};

struct gen_mega {
	avr_t *avr;
	char message[MESSAGE_SIZE];
	int stop;         /* an enum gen_stop, valid when stopped is set */
	int stopped;      /* a hook asked the run to end */
	int crashed;      /* for good */
	int resume;       /* simavr's state before the stop */
	uint32_t resets;  /* since the first one */
	int timers_lost;  /* a reset dropped the cycle timers */
	avr_cycle_count_t limit;
	void (*core_reset)(avr_t *);
	struct records records;
	struct uart uart;
};

/* ---- stopping ------------------------------------------------------------------------------------------------- */

static struct gen_mega *of(const avr_t *avr)
{
	return avr->custom.data;
}

static void stop(struct gen_mega *mega, int reason)
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

static void note(struct gen_mega *mega, const char *format, ...)
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
	stop(mega, STOP_CRASHED);
}

static avr_cycle_count_t at_limit(avr_t *avr, avr_cycle_count_t when, void *parameter)
{
	(void)avr;
	(void)when;
	stop(parameter, STOP_LIMIT);
	return 0;
}

static void no_sleep(avr_t *avr, avr_cycle_count_t cycles)
{
	(void)avr;
	(void)cycles; /* idle time passes in the cycle counter alone */
}

/* ---- UART0 ---------------------------------------------------------------------------------------------------- */

static void uart_output(avr_irq_t *irq, uint32_t value, void *parameter)
{
	(void)irq;
	struct gen_mega *mega = parameter;
	struct uart *uart = &mega->uart;
	if (uart->taken > UART_KEEP && uart->seen_from > UART_KEEP) { /* drop what has been read */
		size_t drop = uart->taken < uart->seen_from ? uart->taken : uart->seen_from;
		memmove(uart->captured, uart->captured + drop, uart->captured_length - drop);
		uart->captured_length -= drop;
		uart->taken -= drop;
		uart->seen_from -= drop;
	}
	if (uart->captured_length == uart->captured_capacity) {
		size_t capacity = uart->captured_capacity ? 2 * uart->captured_capacity : 4096;
		uint8_t *larger = realloc(uart->captured, capacity);
		if (!larger) {
			note(mega, "out of memory for the bytes that UART0 sent");
			stop(mega, STOP_PROTOCOL);
			return;
		}
		uart->captured = larger;
		uart->captured_capacity = capacity;
	}
	uart->captured[uart->captured_length++] = (uint8_t)value;
	size_t length = uart->pattern_length;
	if (length && uart->captured_length - uart->seen_from >= length &&
	    !memcmp(uart->captured + uart->captured_length - length, uart->pattern, length)) {
		uart->seen_from = uart->captured_length;
		stop(mega, STOP_PATTERN);
	}
}

static void uart_xon(avr_irq_t *irq, uint32_t value, void *parameter)
{
	(void)irq;
	(void)value;
	((struct gen_mega *)parameter)->uart.full = 0;
}

static void uart_xoff(avr_irq_t *irq, uint32_t value, void *parameter)
{
	(void)irq;
	(void)value;
	((struct gen_mega *)parameter)->uart.full = 1;
}

static avr_cycle_count_t uart_feed(avr_t *avr, avr_cycle_count_t when, void *parameter)
{
	(void)avr;
	struct uart *uart = &((struct gen_mega *)parameter)->uart;
	if (uart->queue_head < uart->queue_length && !uart->full)
		avr_raise_irq(uart->input, uart->queue[uart->queue_head++]);
	return uart->queue_head < uart->queue_length ? when + uart->byte_cycles : 0;
}

/* ---- the mailbox ---------------------------------------------------------------------------------------------- */

static void give_record(struct gen_mega *mega)
{
	struct records *records = &mega->records;
	memcpy(mega->avr->data + records->in_address, records->in + (size_t)records->next * records->in_size,
	       records->in_size);
	records->stepping = 1;
	records->start = mega->avr->cycle;
}

static void take_record(struct gen_mega *mega)
{
	struct records *records = &mega->records;
	memcpy(records->out + (size_t)records->next * records->out_size, mega->avr->data + records->out_address,
	       records->out_size);
	records->cycles[records->next] = (uint32_t)(mega->avr->cycle - records->start);
	records->stepping = 0;
	if (++records->next == records->count) {
		records->active = 0;
		stop(mega, STOP_RECORDS);
	}
}

static void gpior0_written(avr_t *avr, avr_io_addr_t address, uint8_t value, void *parameter)
{
	struct gen_mega *mega = parameter;
	avr->data[address] = value;
	if (value == 1) {
		if (mega->records.active && mega->records.stepping) {
			note(mega, "the firmware asked for record %u before it finished record %u",
			     (unsigned)mega->records.next + 1, (unsigned)mega->records.next);
			stop(mega, STOP_PROTOCOL);
		} else if (mega->records.active) {
			give_record(mega);
		}
	} else if (value == 2 && mega->records.active) {
		if (mega->records.stepping) {
			take_record(mega);
		} else {
			note(mega, "the firmware finished record %u without having asked for it",
			     (unsigned)mega->records.next);
			stop(mega, STOP_PROTOCOL);
		}
	}
}

/* ---- opening and closing -------------------------------------------------------------------------------------- */

static void on_reset(avr_t *avr)
{
	struct gen_mega *mega = of(avr);
	if (mega->core_reset)
		mega->core_reset(avr);
	mega->resets++;
	mega->timers_lost = 1;
	mega->records.stepping = 0;
	mega->uart.full = 0;
}

static void attach_devices(struct gen_mega *mega)
{
	avr_t *avr = mega->avr;
	uint32_t flags = 0; /* no printing, no sleeping while the firmware polls */
	avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
	avr_irq_t *base = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), 0);
	mega->uart.input = base + UART_IRQ_INPUT;
	avr_irq_register_notify(base + UART_IRQ_OUTPUT, uart_output, mega);
	avr_irq_register_notify(base + UART_IRQ_OUT_XON, uart_xon, mega);
	avr_irq_register_notify(base + UART_IRQ_OUT_XOFF, uart_xoff, mega);
	avr_register_io_write(avr, GPIOR0, gpior0_written, mega);
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
	free(mega->uart.captured);
	free(mega->uart.queue);
	free(mega);
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
		note(mega, "simavr cannot read the ELF file");
		return mega;
	}
	mega->avr = avr_make_mcu_by_name("atmega2560");
	if (!mega->avr) {
		note(mega, "this libsimavr has no atmega2560");
		free_firmware(&firmware);
		return mega;
	}
	avr_init(mega->avr);
	mega->avr->log = LOG_ERROR;
	mega->avr->custom.data = mega;
	strcpy(firmware.mmcu, "atmega2560");
	firmware.frequency = FREQUENCY_HZ;
	avr_load_firmware(mega->avr, &firmware);
	free_firmware(&firmware);
	mega->avr->frequency = FREQUENCY_HZ;
	mega->avr->sleep = no_sleep;
	mega->core_reset = mega->avr->reset;
	mega->avr->reset = on_reset;
	mega->timers_lost = 1;
	mega->uart.byte_cycles = 1;
	attach_devices(mega);
	return mega;
}

const char *gen_mega_message(const struct gen_mega *mega)
{
	return mega->message;
}

/* ---- state ---------------------------------------------------------------------------------------------------- */

uint64_t gen_mega_cycle(const struct gen_mega *mega)
{
	return mega->avr->cycle;
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

/* ---- UART0, the outer side ------------------------------------------------------------------------------------ */

size_t gen_mega_uart_available(const struct gen_mega *mega)
{
	return mega->uart.captured_length - mega->uart.taken;
}

size_t gen_mega_uart_take(struct gen_mega *mega, uint8_t *to, size_t capacity)
{
	size_t count = gen_mega_uart_available(mega);
	if (count > capacity)
		count = capacity;
	if (count)
		memcpy(to, mega->uart.captured + mega->uart.taken, count);
	mega->uart.taken += count;
	return count;
}

/* Queue bytes for the receiver, one every byte_cycles from now on. 0 when it worked. */
int gen_mega_uart_send(struct gen_mega *mega, const uint8_t *bytes, size_t count, uint32_t byte_cycles)
{
	struct uart *uart = &mega->uart;
	if (!count)
		return 0;
	size_t left = uart->queue_length - uart->queue_head;
	uint8_t *queue = malloc(left + count);
	if (!queue)
		return -1;
	if (left)
		memcpy(queue, uart->queue + uart->queue_head, left);
	memcpy(queue + left, bytes, count);
	free(uart->queue);
	uart->queue = queue;
	uart->queue_head = 0;
	uart->queue_length = left + count;
	uart->byte_cycles = byte_cycles ? byte_cycles : 1;
	if (!avr_cycle_timer_status(mega->avr, uart_feed, mega))
		avr_cycle_timer_register(mega->avr, uart->byte_cycles, uart_feed, mega);
	return 0;
}

/* ---- running -------------------------------------------------------------------------------------------------- */

static void arm_timers(struct gen_mega *mega)
{
	mega->timers_lost = 0;
	avr_cycle_count_t now = mega->avr->cycle;
	avr_cycle_timer_cancel(mega->avr, at_limit, mega);
	avr_cycle_timer_register(mega->avr, mega->limit > now ? mega->limit - now : 1, at_limit, mega);
	if (mega->uart.queue_head < mega->uart.queue_length &&
	    !avr_cycle_timer_status(mega->avr, uart_feed, mega))
		avr_cycle_timer_register(mega->avr, mega->uart.byte_cycles, uart_feed, mega);
}

static int run(struct gen_mega *mega, uint64_t limit)
{
	avr_t *avr = mega->avr;
	if (mega->crashed)
		return STOP_CRASHED;
	if (avr->state == cpu_Done)
		return STOP_ENDED;
	if (avr->cycle >= limit)
		return STOP_LIMIT;
	if (avr->state == cpu_Stopped)
		avr->state = mega->resume;
	mega->limit = limit;
	mega->stopped = 0;
	arm_timers(mega);
	while (!mega->stopped) {
		int state = avr_run(avr);
		if (mega->stopped)
			break;
		if (state == cpu_Crashed) {
			if (!mega->crashed)
				note(mega, "the firmware jumped to an address outside its flash");
			mega->crashed = 1;
			return STOP_CRASHED;
		}
		if (state == cpu_Done)
			return STOP_ENDED;
		if (mega->timers_lost)
			arm_timers(mega);
	}
	avr_cycle_timer_cancel(avr, at_limit, mega);
	return mega->stop;
}

/* Run until the cycle counter reaches limit, or until length bytes of pattern have left UART0 (none when 0).
 * Bytes sent before gen_mega_uart_forget() or up to the last match do not count. */
int gen_mega_run(struct gen_mega *mega, uint64_t limit, const uint8_t *pattern, size_t length)
{
	if (length > PATTERN_SIZE) {
		note(mega, "the awaited pattern is longer than %d bytes", PATTERN_SIZE);
		return STOP_PROTOCOL;
	}
	if (length)
		memcpy(mega->uart.pattern, pattern, length);
	mega->uart.pattern_length = length;
	int reason = run(mega, limit);
	mega->uart.pattern_length = 0;
	return reason;
}

/* Forget what UART0 sent so far as far as patterns go: a pattern must lie wholly in later bytes. */
void gen_mega_uart_forget(struct gen_mega *mega)
{
	mega->uart.seen_from = mega->uart.captured_length;
}

/* Serve count records through the mailbox; done tells how many were finished. */
int gen_mega_run_records(struct gen_mega *mega, const uint8_t *in, uint32_t in_address, uint32_t in_size, uint8_t *out,
			 uint32_t out_address, uint32_t out_size, uint32_t count, uint32_t *cycles, uint64_t limit,
			 uint32_t *done)
{
	*done = 0;
	uint32_t end = mega->avr->ramend + 1u;
	if (in_address > end || in_size > end - in_address || out_address > end || out_size > end - out_address) {
		note(mega, "a mailbox lies outside the SRAM");
		return STOP_PROTOCOL;
	}
	mega->records = (struct records){.in = in, .out = out, .cycles = cycles, .in_size = in_size,
					 .out_size = out_size, .count = count, .in_address = (uint16_t)in_address,
					 .out_address = (uint16_t)out_address, .active = count != 0};
	int reason = count ? run(mega, limit) : STOP_RECORDS;
	mega->records.active = 0;
	*done = mega->records.next;
	return reason;
}
