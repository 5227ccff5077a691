/** Durations and numbers of PDL as words. Pure. */

/** Durations within a text in words: `P1M5S` becomes `1 min 5 s`. The form is ISO 8601 with days, hours, minutes and seconds, as printed
 * by Apex. */
export function withDurations(text: string): string {
  return text.replace(/\bP(?=\d)((?:\d+(?:\.\d+)?[DHMS])+)\b/g, (_, parts: string) =>
    [...parts.matchAll(/(\d+(?:\.\d+)?)([DHMS])/g)]
      .map(([, number, unit]) => `${shortNumber(number ?? '')} ${UNITS[unit ?? ''] ?? unit}`)
      .join(' '),
  );
}

const UNITS: Record<string, string> = { D: 'd', H: 'h', M: 'min', S: 's' };

function shortNumber(text: string): string {
  return text.includes('.') ? String(Number(Number(text).toPrecision(4))) : text;
}

/** `17.4832deg` as `17.48deg`: numbers with three or more fraction digits are rounded to four significant digits, times to seconds. */
export function shortValue(text: string): string {
  return text
    .replace(/\b(\d+:\d\d:\d\d)\.\d+/g, '$1')
    .replace(/-?\d+\.\d{3,}/g, number => String(Number(Number(number).toPrecision(4))));
}
