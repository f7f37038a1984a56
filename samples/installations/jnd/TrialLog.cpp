#include "samples/installations/jnd/TrialLog.h"

#include "haptics/base/InputError.h"
#include "samples/shards/PartFile.h"

#include <fmt/format.h>

namespace midair::samples
{

TrialLog::TrialLog(const std::string& path, const SessionHead& head) :
    _path(path),
    _file(path, "results", 0600)
{
    const std::string begin = headText(head);
    const std::string& text = _file.text();
    if (text.size() < begin.size() && begin.compare(0, text.size(), text) == 0)
    {
        if (!text.empty())
            _dropped = fmt::format("results \"{}\" ended within their head; begun anew", path);
        _file.replace(begin);
        _results = TrialFile::parse(begin, path);
        return;
    }
    _results = TrialFile::parse(text, path);
    const std::string other = differenceOf(_results.head.toJson(), head.toJson());
    if (!other.empty())
        throw base::InputError(fmt::format(
            "results \"{}\" are of another session and stay as they are: {} (there, and here); "
            "take another file with --results",
            path,
            other));
    const std::string torn = _file.tornLine();
    if (torn.empty()) return;
    _dropped = fmt::format("results \"{}\": the last line, \"{}\", has no end and is dropped; its "
                           "trial is played again",
                           path,
                           torn);
    _file.cutTornLine();
}

void TrialLog::add(bool isFelt, const Trial& played)
{
    Trial trial = played;
    Staircase& staircase = _results.staircase;
    trial.number = staircase.trials() + 1;
    trial.run = staircase.run();
    trial.value = staircase.value();
    trial.isFelt = isFelt;
    _file.append(lineOf(trial));
    _file.sync();
    staircase.answer(isFelt);
    _results.trials.push_back(trial);
}

void TrialLog::addVoid(const std::string& why)
{
    const std::string line = lineOfVoid(_results.staircase.trials() + 1, why);
    _file.append(line);
    _file.sync();
    _results.voided.push_back(line);
}

} // namespace midair::samples
