/** Reads the pixels on the screen. */

import type { Locator, Page } from '@playwright/test';

/** How many pixels of an element have each of the colours (`#rrggbb`), within a few steps of each channel. */
export async function countColours(
  page: Page,
  element: Locator,
  colours: string[],
): Promise<Record<string, number>> {
  const png = (await element.screenshot()).toString('base64');
  return page.evaluate(
    async ({ png, colours }) => {
      const image = new Image();
      image.src = `data:image/png;base64,${png}`;
      await image.decode();
      const canvas = document.createElement('canvas');
      canvas.width = image.width;
      canvas.height = image.height;
      const context = canvas.getContext('2d');
      if (!context) throw new Error('there is no canvas');
      context.drawImage(image, 0, 0);
      const { data } = context.getImageData(0, 0, image.width, image.height);
      const near = 10;
      return Object.fromEntries(
        colours.map(colour => {
          const wanted = [1, 3, 5].map(at => Number.parseInt(colour.slice(at, at + 2), 16));
          let count = 0;
          for (let at = 0; at < data.length; at += 4) {
            if (wanted.every((value, channel) => Math.abs((data[at + channel] ?? 0) - value) <= near))
              count += 1;
          }
          return [colour, count];
        }),
      );
    },
    { png, colours },
  );
}

/**
 * The longest run of rows of pixels of an element in which no pixel has the colour (`#rrggbb`), within a few steps. The picture is that of the
 * whole page: a picture of one element alone may be composed otherwise.
 */
export async function rowsWithout(page: Page, element: Locator, colour: string): Promise<number> {
  const box = await element.boundingBox();
  if (!box) throw new Error('the element is not on the page');
  const png = (await page.screenshot()).toString('base64');
  return page.evaluate(
    async ({ png, colour, box }) => {
      const image = new Image();
      image.src = `data:image/png;base64,${png}`;
      await image.decode();
      const canvas = document.createElement('canvas');
      [canvas.width, canvas.height] = [image.width, image.height];
      const context = canvas.getContext('2d');
      if (!context) throw new Error('there is no canvas');
      context.drawImage(image, 0, 0);
      const wanted = [1, 3, 5].map(at => Number.parseInt(colour.slice(at, at + 2), 16));
      const has = (row: number) => {
        const { data } = context.getImageData(box.x, row, box.width, 1);
        for (let at = 0; at < data.length; at += 4)
          if (wanted.every((value, channel) => Math.abs((data[at + channel] ?? 0) - value) <= 6)) return true;
        return false;
      };
      let [run, longest] = [0, 0];
      // Whole pixels only: an edge between two pixels is blended with what is next to it.
      for (let row = Math.ceil(box.y); row < Math.floor(box.y + box.height); row += 1) {
        run = has(row) ? 0 : run + 1;
        longest = Math.max(longest, run);
      }
      return longest;
    },
    { png, colour, box },
  );
}
