// Films: the growth of a plant, or a turn around it. The view draws each picture, and the browser records it.
import { nextFrame } from "../view/frames.js";
import type { View } from "../view/scene.js";
import type { Studio } from "./studio.js";
import { webmOf } from "./webm.js";
import type { CodedPicture } from "./webm.js";

const FRAME_MILLISECONDS = 100;
const REST_MILLISECONDS = 1200; // of the last picture
const MOST_FRAMES = 300;
const TURN_FRAMES = 72;
const TURN_MILLISECONDS = 70;

const rest = (milliseconds: number) => new Promise((done) => setTimeout(done, milliseconds));

const BITS_PER_SECOND = 8_000_000;
const KEY_MILLISECONDS = 5000; // between pictures that need no picture before them
const MOST_WAITING = 4; // pictures that the encoder has not begun

/** Records what `pictures` draws; each of its numbers is the milliseconds for which the last picture stays. */
async function record(view: View, pictures: AsyncIterable<number>): Promise<Blob> {
  const { width, height } = view.renderer.domElement;
  // of an even width and height, as encoders want it
  const config = { codec: "vp8", width: width & ~1, height: height & ~1, bitrate: BITS_PER_SECOND };
  // browsers give encoders to pages of https and of this machine only
  const canEncode = typeof VideoEncoder !== "undefined" && (await VideoEncoder.isConfigSupported(config)).supported;
  return canEncode ? encode(view, pictures, config) : recordLive(view, pictures);
}

/** No picture is lost, and each has its time, also where a machine is too slow to draw them in it. */
async function encode(view: View, pictures: AsyncIterable<number>, config: VideoEncoderConfig): Promise<Blob> {
  const { width, height } = config;
  const coded: CodedPicture[] = [];
  const problems: Error[] = [];
  const encoder = new VideoEncoder({
    output: (chunk) => {
      const data = new Uint8Array(chunk.byteLength);
      chunk.copyTo(data);
      coded.push({ data, milliseconds: chunk.timestamp / 1000, isKey: chunk.type === "key" });
    },
    error: (error) => problems.push(error),
  });
  encoder.configure(config);
  // the film keeps its size when the view gets another one
  const canvas = Object.assign(document.createElement("canvas"), { width, height });
  const context = canvas.getContext("2d", { alpha: false })!;
  let time = 0;
  let nextKey = 0;
  for await (const milliseconds of pictures) {
    context.drawImage(view.composed(), 0, 0, width, height);
    const frame = new VideoFrame(canvas, { timestamp: 1000 * time, duration: 1000 * milliseconds });
    encoder.encode(frame, { keyFrame: time >= nextKey });
    frame.close();
    nextKey = time >= nextKey ? time + KEY_MILLISECONDS : nextKey;
    time += milliseconds;
    do {
      await rest(0); // a person may stop it
    } while (encoder.encodeQueueSize > MOST_WAITING && problems.length === 0);
  }
  if (problems.length === 0) {
    await encoder.flush();
    encoder.close();
  }
  if (problems.length > 0) {
    throw new Error(`The browser's encoder failed: ${problems[0].message}`);
  }
  return webmOf(coded, "V_VP8", width, height, time);
}

/** The browser records the view while it is drawn: slow pictures make a slow film. */
async function recordLive(view: View, pictures: AsyncIterable<number>): Promise<Blob> {
  if (typeof MediaRecorder === "undefined" || !MediaRecorder.isTypeSupported("video/webm")) {
    throw new Error("This browser records no WebM. Use espalier run with --every -o growth.webm, or with --turntable 48 -o turn.webm.");
  }
  const stream = view.renderer.domElement.captureStream(0);
  const [track] = stream.getVideoTracks() as CanvasCaptureMediaStreamTrack[];
  const recorder = new MediaRecorder(stream, { mimeType: "video/webm", videoBitsPerSecond: BITS_PER_SECOND });
  const pieces: Blob[] = [];
  recorder.ondataavailable = ({ data }) => pieces.push(data);
  const stopped = new Promise((done) => (recorder.onstop = done));
  try {
    recorder.start();
    for await (const milliseconds of pictures) {
      track.requestFrame();
      await Promise.all([nextFrame(), rest(milliseconds)]);
    }
  } finally {
    recorder.stop();
    await stopped;
    track.stop();
  }
  return new Blob(pieces, { type: "video/webm" });
}

/** Records from the first step to the present one. `signal` ends it early: the film has what was recorded. */
export async function filmGrowth(studio: Studio, signal: AbortSignal): Promise<Blob> {
  const last = studio.step;
  const { simulation } = studio;
  // another model is opened
  const isOver = () => signal.aborted || studio.simulation !== simulation;
  const stride = Math.max(1, Math.ceil(last / MOST_FRAMES));
  async function* steps() {
    for (let step = 0; ; step = Math.min(step + stride, last)) {
      await studio.goTo(step);
      await drawn(studio, step, isOver);
      if (isOver() || studio.answeredStep < step) {
        return;
      }
      if (step === last) {
        // a second picture gives the last one its time
        yield REST_MILLISECONDS;
        yield FRAME_MILLISECONDS;
        return;
      }
      yield FRAME_MILLISECONDS;
    }
  }
  try {
    return await record(studio.view!, steps());
  } finally {
    if (studio.simulation === simulation) {
      await studio.goTo(last);
    }
  }
}

/** Records a turn around the plant; the camera ends where it was. */
export async function filmTurn(studio: Studio, signal: AbortSignal): Promise<Blob> {
  const view = studio.view!;
  async function* turns() {
    for (let i = 0; i < TURN_FRAMES && !signal.aborted; ++i) {
      view.turn((2 * Math.PI) / TURN_FRAMES);
      view.drawNow();
      yield TURN_MILLISECONDS;
    }
  }
  const place = view.camera.position.clone();
  try {
    return await record(view, turns());
  } finally {
    view.camera.position.copy(place);
    view.controls.update();
  }
}

async function drawn(studio: Studio, step: number, isOver: () => boolean): Promise<void> {
  const { element } = studio.view!;
  while (element.dataset.step !== String(step) && studio.answeredStep >= step && !isOver()) {
    await nextFrame();
  }
  await studio.extras.meshOf(step, isOver);
  studio.view!.drawNow();
}
