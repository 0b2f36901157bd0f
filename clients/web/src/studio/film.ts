// The growth of a plant as a film: the view draws each step, and the browser records it.
import { nextFrame } from "../view/frames.js";
import type { Studio } from "./studio.js";

const FRAME_MILLISECONDS = 100;
const REST_MILLISECONDS = 1200; // of the last picture
const MOST_FRAMES = 300;

const rest = (milliseconds: number) => new Promise((done) => setTimeout(done, milliseconds));

/** Records from the first step to the present one. `signal` ends it early: the film has what was recorded. */
export async function filmGrowth(studio: Studio, signal: AbortSignal): Promise<Blob> {
  const view = studio.view!;
  if (typeof MediaRecorder === "undefined" || !MediaRecorder.isTypeSupported("video/webm")) {
    throw new Error("This browser records no WebM. Save pictures of the steps with espalier run --every -o step%d.png instead.");
  }
  const last = studio.step;
  const stride = Math.max(1, Math.ceil(last / MOST_FRAMES));
  const stream = view.renderer.domElement.captureStream(0);
  const [track] = stream.getVideoTracks() as CanvasCaptureMediaStreamTrack[];
  const recorder = new MediaRecorder(stream, { mimeType: "video/webm", videoBitsPerSecond: 8_000_000 });
  const pieces: Blob[] = [];
  recorder.ondataavailable = ({ data }) => pieces.push(data);
  const stopped = new Promise((done) => (recorder.onstop = done));
  try {
    recorder.start();
    for (let step = 0; !signal.aborted; step = Math.min(step + stride, last)) {
      await studio.goTo(step);
      await drawn(studio, step, signal);
      track.requestFrame();
      await rest(FRAME_MILLISECONDS);
      if (step === last) {
        // a second picture gives the last one its time
        await rest(REST_MILLISECONDS);
        track.requestFrame();
        await rest(FRAME_MILLISECONDS);
        break;
      }
    }
  } finally {
    recorder.stop();
    await stopped;
    track.stop();
    await studio.goTo(last);
  }
  return new Blob(pieces, { type: "video/webm" });
}

async function drawn(studio: Studio, step: number, signal: AbortSignal): Promise<void> {
  const { element } = studio.view!;
  while (element.dataset.step !== String(step) && studio.simulation && !signal.aborted) {
    await nextFrame();
  }
  studio.view!.drawNow();
}
