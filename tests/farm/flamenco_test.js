// The Flamenco job type under a stand-in of Flamenco's API: what it authors, and that its commands make a picture.
//   node flamenco_test.js JOB_TYPE.js SCENE.toml OUT.exr COVBEAM
"use strict";
const assert = require("node:assert/strict");
const { spawnSync } = require("node:child_process");
const fs = require("node:fs");
const vm = require("node:vm");

const [script, scene, out, covbeam] = process.argv.slice(2);

// compile SETTINGS: the tasks that the job type makes of a job with these settings and the defaults.
function compile(settings) {
    const tasks = [];
    const world = {
        author: {
            Task(name, type) {
                assert.ok(name.trim() && type.trim(), "a task needs a name and a type");
                const task = { name, type, commands: [], dependencies: [] };
                task.addCommand = (command) => { task.commands.push(command); };
                task.addDependency = (on) => { task.dependencies.push(on.name); };
                return task;
            },
            Command(name, parameters) {
                return { name, parameters };
            },
        },
        print() {},
    };
    vm.createContext(world);
    vm.runInContext(fs.readFileSync(script, "utf8") + "\nthis.JOB_TYPE = JOB_TYPE;", world, { filename: script });
    const known = new Map(world.JOB_TYPE.settings.map((setting) => [setting.key, setting]));
    assert.equal(known.size, world.JOB_TYPE.settings.length, "a key is there twice");
    const all = {};
    for (const [key, setting] of known) {
        assert.ok(["string", "int32", "float", "bool"].includes(setting.type), key);
        assert.ok(["visible", "hidden", "submission", "web", undefined].includes(setting.visible), key);
        assert.ok(["file_path", "dir_path", "file_name", "hashed_file_path", undefined].includes(setting.subtype), key);
        assert.ok(!setting.choices || setting.choices.includes(setting.default), key);
        assert.ok(setting.required || setting.default !== undefined, `${key}: neither required nor with a default`);
        all[key] = setting.default;
    }
    for (const key of Object.keys(settings)) {
        assert.ok(known.has(key), key);
    }
    // As Flamenco does it: what is added to a task after the job has got it is lost.
    const addTask = (task) => {
        tasks.push({ ...task, commands: [...task.commands], dependencies: [...task.dependencies] });
    };
    world.compileJob({ name: "test", settings: { ...all, ...settings }, addTask });
    for (const task of tasks) {
        assert.equal(task.commands.length, 1, task.name);
        assert.equal(task.commands[0].name, "exec");
        const { exe, args } = task.commands[0].parameters;
        assert.ok([exe, ...args].every((word) => typeof word === "string"), "Flamenco takes words only");
    }
    assert.equal(new Set(tasks.map((task) => task.name)).size, tasks.length, "a name is there twice");
    return tasks;
}

const option = (task, name) => {
    const args = task.commands[0].parameters.args;
    return args.includes(name) ? args[args.indexOf(name) + 1] : undefined;
};

// The pieces: every pass once, and the merge waits for them all.
for (const [passes, each, expected] of [
    [20, 8, ["0..8", "8..16", "16..20"]],
    [16, 8, ["0..8", "8..16"]],
    [3, 8, ["0..3"]],
    [2, 1, ["0..1", "1..2"]],
]) {
    const tasks = compile({ scene: "/s/a.toml", out: "/s/a.exr", passes, passes_a_task: each });
    const merge = tasks.pop();
    assert.deepEqual(tasks.map((task) => option(task, "--passes")), expected);
    assert.deepEqual([...merge.dependencies], tasks.map((task) => task.name));
    const shards = tasks.map((task) => option(task, "--out"));
    assert.equal(new Set(shards).size, shards.length);
    assert.deepEqual([...merge.commands[0].parameters.args.slice(1, 1 + shards.length)], shards);
    assert.equal(option(merge, "--passes"), `${passes}`);
    assert.equal(option(merge, "--out"), "/s/a.exr");
    assert.ok(tasks.every((task) => option(task, "--seed") === undefined));
}
const [piece] = compile({
    scene: "{job}/a.toml", out: "Z:\\b.exr", seed: "7", method: "ppb", covbeam: "{covbeam}",
});
assert.equal(option(piece, "--seed"), "7");
assert.equal(option(piece, "--method"), "ppb");
assert.equal(option(piece, "--out"), "Z:\\b-0-8.shard");
assert.equal(piece.commands[0].parameters.exe, "{covbeam}");

// Refused when the job is submitted, not on a worker an hour later.
for (const [wrong, message] of [
    [{ out: "/s/a.png" }, /must end in \.exr/],
    [{ scene: "a.toml" }, /absolute path/],
    [{ passes: 0 }, /passes is 0/],
    [{ passes_a_task: -1 }, /passes_a_task is -1/],
]) {
    assert.throws(() => compile({ scene: "/s/a.toml", out: "/s/a.exr", ...wrong }),
        (thrown) => message.test(thrown), `${message}`);
}

// For real, the pieces in reverse order.
const tasks = compile({ scene, out, passes: 20, passes_a_task: 8, covbeam });
const done = [];
for (const task of [...tasks.slice(0, -1).reverse(), tasks[tasks.length - 1]]) {
    assert.ok(task.dependencies.every((name) => done.includes(name)), `${task.name} comes too early`);
    const { exe, args } = task.commands[0].parameters;
    const result = spawnSync(exe, args, { encoding: "utf8" });
    assert.equal(result.status, 0, `${task.name}: ${result.stderr}`);
    done.push(task.name);
}
console.log(`flamenco_test.js: ${tasks.length} tasks as expected, and run`);
