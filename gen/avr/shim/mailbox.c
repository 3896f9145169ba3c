/* Records in and out of a harness built with ../mailbox.h, and the cycles between its marks. */
#include "mailbox.h"

#include "run.h"

#include <stdlib.h>
#include <string.h>

#define GPIOR0 0x3e /* data address */

struct records {
	const uint8_t *in;
	uint8_t *out;
	uint32_t *cycles;
	uint32_t in_size, out_size, count, next;
	uint16_t in_address, out_address;
	int active;   /* a run_records call is under way */
	int stepping; /* between mark 1 and mark 2 */
	avr_cycle_count_t start;
};

static void give_record(struct gen_mega *mega)
{
	struct records *records = mega->records;
	memcpy(mega->avr->data + records->in_address, records->in + (size_t)records->next * records->in_size,
	       records->in_size);
	records->stepping = 1;
	records->start = mega->avr->cycle;
}

static void take_record(struct gen_mega *mega)
{
	struct records *records = mega->records;
	memcpy(records->out + (size_t)records->next * records->out_size, mega->avr->data + records->out_address,
	       records->out_size);
	records->cycles[records->next] = (uint32_t)(mega->avr->cycle - records->start);
	records->stepping = 0;
	if (++records->next == records->count) {
		records->active = 0;
		mega_stop(mega, STOP_RECORDS);
	}
}

static void gpior0_written(avr_t *avr, avr_io_addr_t address, uint8_t value, void *parameter)
{
	struct gen_mega *mega = parameter;
	avr->data[address] = value;
	if (value == 1) {
		if (mega->records->active && mega->records->stepping) {
			mega_note(mega, "the firmware asked for record %u before it finished record %u",
			     (unsigned)mega->records->next + 1, (unsigned)mega->records->next);
			mega_stop(mega, STOP_PROTOCOL);
		} else if (mega->records->active) {
			give_record(mega);
		}
	} else if (value == 2 && mega->records->active) {
		if (mega->records->stepping) {
			take_record(mega);
		} else {
			mega_note(mega, "the firmware finished record %u without having asked for it",
			     (unsigned)mega->records->next);
			mega_stop(mega, STOP_PROTOCOL);
		}
	}
}

static int attach(struct gen_mega *mega)
{
	mega->records = calloc(1, sizeof *mega->records);
	if (!mega->records)
		return -1;
	avr_register_io_write(mega->avr, GPIOR0, gpior0_written, mega);
	return 0;
}

static void reset(struct gen_mega *mega)
{
	mega->records->stepping = 0;
}

static void close_mailbox(struct gen_mega *mega)
{
	free(mega->records);
}

const struct part mega_mailbox_part = {.attach = attach, .reset = reset, .close = close_mailbox};

int gen_mega_run_records(struct gen_mega *mega, const uint8_t *in, uint32_t in_address, uint32_t in_size, uint8_t *out,
			 uint32_t out_address, uint32_t out_size, uint32_t count, uint32_t *cycles, uint64_t limit,
			 uint32_t *done)
{
	*done = 0;
	uint32_t end = mega->avr->ramend + 1u;
	if (in_address > end || in_size > end - in_address || out_address > end || out_size > end - out_address) {
		mega_note(mega, "a mailbox lies outside the SRAM");
		return STOP_PROTOCOL;
	}
	*mega->records = (struct records){.in = in, .out = out, .cycles = cycles, .in_size = in_size,
					  .out_size = out_size, .count = count, .in_address = (uint16_t)in_address,
					  .out_address = (uint16_t)out_address, .active = count != 0};
	int reason = count ? mega_run(mega, limit) : STOP_RECORDS;
	mega->records->active = 0;
	*done = mega->records->next;
	return reason;
}
