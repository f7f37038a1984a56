#pragma once

#include "samples/tools/bake/BakeScene.h"

#include <string>
#include <vector>

namespace midair::samples
{

/// Solves a shard. With a single one (1/1) \a arguments.out becomes the recording, and what is done
/// is kept in a part beside it until then; else it is the part. Goes on with a part that is there.
/// Returns the program's exit code: 0, or 1 if nothing is felt in any of its frames. Throws
/// base::InputError.
int bake(const BakeArguments& arguments);

/// Joins \a parts to a recording. Throws base::InputError.
void mergeBaked(const std::vector<std::string>& parts, const std::string& out, bool overwrite);

/// Solves some frames and prints what many cost: time of a processor core, bytes, and time on
/// several cores. Writes nothing.
void estimate(const BakeArguments& arguments);

/// Bakes with one process and with \a processes at the same time, \a repeats times in turn, and
/// prints throughput and time of a processor core for each field. \a program: this program's file.
void measureScaling(const BakeArguments& arguments,
                    int processes,
                    int repeats,
                    const std::string& program);

} // namespace midair::samples
