'use strict';

// A renderer of one picture: the text of this function runs as a worker. A page that was opened as a file may load
// no worker from another file.
function renderer() {
    let wasm = null, generation = -1, pixels = 0, unseen = 0, pictureTime = 0;

    function begin({ width, height, adaptive, settings }) {
        const { lampAngle, ballRadius, index, extinction, photons, plainRadius, seed } = settings;
        wasm.begin(width, height, adaptive, lampAngle, ballRadius, index, extinction, photons, plainRadius, seed);
        pixels = width * height;
        unseen = pictureTime = 0;
    }

    // A picture is made when the passes since the last one have taken longer than it will, and at the end.
    function picture(passes, isLast) {
        if (!isLast && passes > 2 && unseen < pictureTime)
            return {};
        const start = performance.now();
        const radiance = wasm.picture();
        pictureTime = performance.now() - start;
        unseen = 0;
        const shown = wasm.shown(), memory = wasm.memory.buffer;
        return {
            shown: new Uint8ClampedArray(memory, shown, 4 * pixels).slice(),
            radiance: new Float32Array(memory, radiance, 3 * pixels).slice(),
        };
    }

    // Asked for a pass: of the picture that is under way, or the first of another one.
    onmessage = ({ data }) => {
        if (data.module)
            wasm = new WebAssembly.Instance(data.module).exports;
        const start = performance.now();
        if (data.generation !== generation) {
            generation = data.generation;
            begin(data);
        }
        const passes = data.passes + 1;
        wasm.pass();
        unseen += performance.now() - start;
        const made = picture(passes, data.isLast);
        const seconds = (performance.now() - start) / 1000;
        postMessage({ generation, passes, seconds, eyeRays: wasm.eye_rays(), ...made });
    };
}
