/* What the converter of simavr is told: the world's voltages, the supply, and the reference of this very chip. */
#include "analog.h"

#include <simavr/avr_adc.h>

#include <string.h>

#define SUPPLY_MV 5000

int gen_mega_adc(struct gen_mega *mega, uint8_t input, uint32_t millivolts)
{
	if (input > ADC_IRQ_ADC15)
		return -1;
	avr_raise_irq(avr_io_getirq(mega->avr, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_ADC0 + input), millivolts);
	return 0;
}

static avr_adc_t *converter(struct gen_mega *mega)
{
	for (avr_io_t *part = mega->avr->io_port; part; part = part->next)
		if (!strcmp(part->kind, "adc"))
			return (avr_adc_t *)part;
	return NULL;
}

int gen_mega_supply(struct gen_mega *mega, uint32_t millivolts, uint32_t reference)
{
	avr_adc_t *adc = converter(mega);
	uint8_t own = 0;
	if (!adc || millivolts == 0 || reference == 0 || reference >= 1u << 13)
		return -1;
	/* The other reference that can be chosen is ground. */
	while (adc->muxmode[own].kind != ADC_MUX_REF || adc->muxmode[own].src == 0)
		if (++own == sizeof adc->muxmode / sizeof *adc->muxmode)
			return -1;
	mega->avr->vcc = mega->avr->avcc = mega->avr->aref = millivolts;
	adc->muxmode[own].src = reference & 0x1fff;
	return 0;
}

static int attach(struct gen_mega *mega)
{
	mega->avr->vcc = mega->avr->avcc = mega->avr->aref = SUPPLY_MV;
	return 0;
}

static void close_analog(struct gen_mega *mega)
{
	(void)mega;
}

const struct part mega_analog_part = {.attach = attach, .close = close_analog};
