import { expect, it } from 'vitest';
import { SvgPen } from './vector';

const PAPER = { width: 40, height: 30, ground: '#123456' };
const pen = () => new SvgPen(text => ({ width: text.length * 6 }) as TextMetrics);

it('puts ground and picture below the drawing', () => {
  const sheet = pen();
  sheet.fillRect(5, 6, -2, 3);
  const lines = sheet.svg({ ...PAPER, picture: 'data:image/png;base64,AA' }).split('\n');
  expect(lines[1]).toBe('<rect width="40" height="30" fill="#123456"/>');
  expect(lines[2]).toContain('href="data:image/png;base64,AA"');
  expect(lines[3]).toBe('<rect x="3" y="6" width="2" height="3" fill="#000000"/>');
});

it('restores colours, transforms, dashes, and closes what clips', () => {
  const sheet = pen();
  sheet.strokeStyle = '#ff0000';
  sheet.save();
  sheet.rect(0, 0, 10, 10);
  sheet.clip();
  sheet.translate(3, 4);
  sheet.rotate(Math.PI / 2);
  sheet.strokeStyle = '#00ff00';
  sheet.setLineDash([1, 4]);
  sheet.beginPath();
  sheet.lineTo(0, 0);
  sheet.lineTo(5, 0);
  sheet.stroke();
  sheet.restore();
  sheet.beginPath();
  sheet.moveTo(1, 1);
  sheet.lineTo(2, 2);
  sheet.stroke();
  const [clip, inside, end, outside] = sheet.svg(PAPER).split('\n').slice(2);
  expect(clip).toContain('<path d="M0 0h10v10h-10Z"/></clipPath><g clip-path="url(#clip-1)">');
  expect(inside).toBe(
    '<path d="M0 0L5 0" fill="none" stroke="#00ff00" stroke-width="1" stroke-dasharray="1 4" transform="translate(3 4)rotate(90)"/>',
  );
  expect(end).toBe('</g>');
  expect(outside).toBe('<path d="M1 1L2 2" fill="none" stroke="#ff0000" stroke-width="1"/>');
});

it('draws whole circles as two arcs, and words with their font', () => {
  const sheet = pen();
  sheet.arc(10, 10, 5, 0, 2 * Math.PI);
  sheet.fill();
  sheet.font = '600 11.5px Inter, "Segoe UI"';
  sheet.textAlign = 'right';
  sheet.textBaseline = 'middle';
  sheet.fillText('a<b', 7, 8);
  const [circle, words] = sheet.svg(PAPER).split('\n').slice(2);
  expect(circle).toContain('d="M15 10A5 5 0 0 1 5 10A5 5 0 0 1 15 10"');
  expect(words).toBe(
    '<text x="7" y="8" font-family="Inter, &quot;Segoe UI&quot;" font-size="11.5" font-weight="600" text-anchor="end" dy="0.35em" fill="#000000">a&lt;b</text>',
  );
  expect(sheet.measureText('four').width).toBe(24);
});
