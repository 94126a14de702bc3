// A job type for Flamenco 3: one picture of covbeam, in pieces of its passes that a last task adds up.
// Goes into the folder `scripts` beside flamenco-manager.
//
// A task that fails is given to another worker, and goes on from its shard. Flamenco kills what it cancels: that loses
// what was done since the last checkpoint, a minute at most.

const JOB_TYPE = {
    label: "Covbeam",
    description: "Render one picture of light in fog, in pieces, and merge them",
    settings: [
        { key: "scene", type: "string", subtype: "file_path", required: true,
          description: "The scene file, SCENE.toml, where all workers see it" },
        { key: "out", type: "string", subtype: "file_path", required: true,
          description: "The picture, NAME.exr, in a folder that is there and that all workers share; the pieces go " +
                       "beside it" },
        { key: "passes", type: "int32", default: 64, propargs: { min: 1 },
          description: "Passes of the picture" },
        { key: "passes_a_task", type: "int32", default: 8, propargs: { min: 1 }, visible: "submission",
          description: "Passes of one task" },
        { key: "method", type: "string", choices: ["adaptive", "ppb", "light-trace", "march"], default: "adaptive",
          visible: "submission" },
        { key: "seed", type: "string", default: "", visible: "submission",
          description: "A number; nothing means the seed of the scene" },
        { key: "covbeam", type: "string", default: "covbeam", visible: "submission",
          description: "The executable as the workers find it; a variable of Flamenco may stand here" },
    ]
};

function compileJob(job) {
    const settings = job.settings;
    if (!settings.out.endsWith(".exr")) {
        throw `the picture is "${settings.out}"; it must end in .exr`;
    }
    // Workers run in a folder of their own.
    for (const file of [settings.scene, settings.out]) {
        if (!/^([\/\\{]|[A-Za-z]:)/.test(file)) {
            throw `"${file}" must be an absolute path, or begin with a variable of Flamenco`;
        }
    }
    const passes = whole("passes", settings.passes);
    const each = whole("passes_a_task", settings.passes_a_task);
    const options = ["--method", settings.method || "adaptive"];
    if (settings.seed) {
        options.push("--seed", settings.seed);
    }

    const shards = [];
    const merge = author.Task("merge", "misc");
    for (let from = 0; from < passes; from += each) {
        const to = Math.min(from + each, passes);
        const shard = settings.out.replace(/\.exr$/, `-${from}-${to}.shard`);
        const render = author.Task(`passes ${from} to ${to - 1}`, "misc");
        render.addCommand(author.Command("exec", {
            exe: settings.covbeam || "covbeam",
            args: ["render", settings.scene, "--passes", `${from}..${to}`, "--out", shard].concat(options),
        }));
        job.addTask(render);
        merge.addDependency(render);
        shards.push(shard);
    }
    merge.addCommand(author.Command("exec", {
        exe: settings.covbeam || "covbeam",
        args: ["merge"].concat(shards, ["--passes", `${passes}`, "--out", settings.out]),
    }));
    // The job gets a copy of the task, so only now.
    job.addTask(merge);
}

function whole(name, value) {
    if (!Number.isInteger(value) || value < 1) {
        throw `${name} is ${value}; it must be a whole number from 1 on`;
    }
    return value;
}
