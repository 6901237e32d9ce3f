/* status.h: what the firmware has to say. Bits of `status` are sticky until CLEAR; each is set at the first
 * sample that shows its cause. Bits of STATUS_FAULTS bring the voltage down and keep it there. */

#ifndef STATUS_H
#define STATUS_H

#define STATUS_SENSOR_INVALID       0x00000001u  /* a reading was not finite; the last good one stood in */
#define STATUS_SENSOR_RANGE         0x00000002u  /* a reading lay outside what can be; the last good one stood in */
#define STATUS_REFERENCE_INVALID    0x00000004u  /* a reference was not finite; the last good one stood in */
#define STATUS_REFERENCE_LIMITED    0x00000008u  /* a reference lay outside the model's range and was limited to it */
#define STATUS_REFERENCE_SLEWED     0x00000010u  /* a reference moved too fast and was followed at the largest rate */
#define STATUS_OUTPUT_LIMITED       0x00000020u  /* the voltage was limited to its range */
#define STATUS_OUTPUT_SLEWED        0x00000040u  /* the voltage's change was limited */
#define STATUS_AMPLIFIER_LIMITS     0x00000080u  /* the amplifier told that it was at its limit */
#define STATUS_LOOP_LIMITED         0x00000100u  /* the correction of the feedback reached its limit */
#define STATUS_DEADLINE_MISSED      0x00000200u  /* an interrupt took more cycles than its budget, or overran */
#define STATUS_MODEL                0x00000400u  /* the model's own status word is not 0 */
#define STATUS_LEARN_SKIPPED        0x00000800u  /* a commit was interrupted; its sample taught nothing */
#define STATUS_IMAGE_REFUSED        0x00001000u  /* a parameter image was refused; `image_answer` says why */
#define STATUS_IMAGE_FALLBACK       0x00002000u  /* a stored image was not good: an older one, or the built-in numbers */
#define STATUS_INTERRUPT_LOST       0x00004000u  /* interrupts came more than one and a half periods apart */
#define STATUS_SENSOR_JUMP          0x00008000u  /* a reading lay far from those before and behind it; the last good one stood in */

#define STATUS_FAULT_SELFTEST       0x00010000u  /* this processor does not compute what was verified */
#define STATUS_FAULT_SENSOR         0x00020000u  /* too many readings were none */
#define STATUS_FAULT_STUCK          0x00040000u  /* the reading stayed while the input moved */
#define STATUS_FAULT_FOLLOW         0x00080000u  /* the stage does not follow: amplifier saturated, sensor or stage off */
#define STATUS_FAULT_AMPLIFIER      0x00100000u  /* the amplifier failed, or was at its limit too long */
#define STATUS_FAULT_DEADLINE       0x00200000u  /* too many late interrupts */
#define STATUS_FAULT_OFFSET         0x00400000u  /* HOLD found a larger offset between stage and model than offset_um */
#define STATUS_FAULT_STROKE         0x00800000u  /* the stage did not move through the loop as the model did */
#define STATUS_FAULT_SETTINGS       0x01000000u  /* hysgen_settings_check found an impossible field; the output never moves */
#define STATUS_FAULT_TIMEOUT        0x02000000u  /* a state took longer than state_samples */
#define STATUS_FAULT_RESET          0x04000000u  /* the processor started again without a loss of power: watchdog, or reset pin */
#define STATUS_FAULT_EXCEPTION      0x08000000u  /* an exception or NMI stopped the firmware before that */
#define STATUS_FAULT_MEMORY         0x10000000u  /* code, constants, the end of the stack or the parameters of START are not what they were */
#define STATUS_FAULTS               0x1FFF0000u
#define STATUS_LASTING              (STATUS_FAULT_SELFTEST | STATUS_FAULT_SETTINGS)  /* CLEAR does not clear these */

#endif
