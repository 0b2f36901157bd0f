// Counts the points of a LAS or PLY file in cells by @loaders.gl, a reader that is not ours: count.js FILE SIZE prints
// {points, minimum, maximum, cells: {"i,j,k": count}}, cells by floor(coordinate / SIZE) along the axes of the file.
import { readFileSync } from 'node:fs';
import { parse } from '@loaders.gl/core';
import { LASLoader } from '@loaders.gl/las';
import { PLYLoader } from '@loaders.gl/ply';

const [file, size] = [process.argv[2], Number(process.argv[3])];
const bytes = readFileSync(file);
const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
const cloud = await parse(buffer, file.endsWith('.las') ? LASLoader : PLYLoader, { worker: false, las: { fp64: true, skip: 1 } });
const places = cloud.attributes.POSITION.value;
const cells = {};
const minimum = [Infinity, Infinity, Infinity];
const maximum = [-Infinity, -Infinity, -Infinity];
for (let i = 0; i < places.length; i += 3) {
  const cell = [0, 1, 2].map((axis) => {
    minimum[axis] = Math.min(minimum[axis], places[i + axis]);
    maximum[axis] = Math.max(maximum[axis], places[i + axis]);
    return Math.floor(places[i + axis] / size);
  });
  cells[cell] = (cells[cell] ?? 0) + 1;
}
console.log(JSON.stringify({ points: places.length / 3, minimum, maximum, cells }));
