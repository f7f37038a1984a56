#include "samples/tune/ReadingJournal.h"

#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/threads/SteadyClock.h"

#include <cerrno>
#include <cmath>
#include <filesystem>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

namespace midair::samples
{

namespace
{

constexpr std::size_t kMostBytes = std::size_t(1) << 30;
constexpr double kSync_s = 0.5;

[[noreturn]] void fail(const std::string& path, const char* what)
{
    throw base::InputError(fmt::format(
        "readings \"{}\" can't be {}: {}", path, what, std::generic_category().message(errno)));
}

std::string lineOf(int row, std::complex<double> value, bool isLevel)
{
    const auto text = [](double number)
    { return std::isfinite(number) ? base::exactNumber(number) : std::string("nan"); };
    return isLevel ? fmt::format("{},{}\n", row, text(value.real()))
                   : fmt::format("{},{},{}\n", row, text(value.real()), text(value.imag()));
}

} // namespace

ReadingJournal::ReadingJournal(const std::string& path,
                               const haptics::TuningPlan& plan,
                               const std::string& planSum) :
    _path(path),
    _plan(plan),
    _sum(planSum)
{
    _file = ::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
    if (_file < 0) fail(path, "opened");
    try
    {
        if (::flock(_file, LOCK_EX | LOCK_NB) != 0)
            throw base::InputError("readings \"" + path + "\" are being written by another run");
        begin(base::readRegularFile(path, kMostBytes));
    }
    catch (const base::FileError& error)
    {
        ::close(_file);
        throw base::InputError("readings \"" + path + "\": " + error.what());
    }
    catch (...)
    {
        ::close(_file);
        throw;
    }
}

void ReadingJournal::begin(const std::string& text)
{
    _found = haptics::readingsFromCsv(text, _path, _plan);
    const std::size_t end = text.rfind('\n');
    const off_t whole = end == std::string::npos ? 0 : static_cast<off_t>(end) + 1;
    if (_found.isTorn && ::ftruncate(_file, whole) != 0) fail(_path, "shortened");
    if (whole == 0)
        write(fmt::format("# plan {}\n", _sum));
    else if (_found.planSum != _sum)
        throw base::InputError(fmt::format(
            "readings \"{}\" belong to {}, this plan is {}; take another file with --out",
            _path,
            _found.planSum.empty() ? "no plan that they name" : "plan " + _found.planSum,
            _sum));
}

ReadingJournal::~ReadingJournal()
{
    ::fdatasync(_file);
    ::close(_file);
}

bool ReadingJournal::isRead(int row) const
{
    return std::isfinite(_found.values[row].real());
}

void ReadingJournal::write(const std::string& text)
{
    for (std::size_t done = 0; done < text.size();)
    {
        const ssize_t wrote = ::write(_file, text.data() + done, text.size() - done);
        if (wrote < 0 && errno == EINTR) continue;
        if (wrote < 0) fail(_path, "written");
        done += static_cast<std::size_t>(wrote);
    }
    const double now_s = base::steadySeconds();
    if (now_s - _synced_s < kSync_s) return;
    if (::fdatasync(_file) != 0) fail(_path, "written");
    _synced_s = now_s;
}

void ReadingJournal::append(int row, std::complex<double> value, bool isLevel)
{
    write(lineOf(row, value, isLevel));
    _found.values[row] = value;
    _found.areLevels = isLevel;
}

void ReadingJournal::forget(int place)
{
    std::error_code error;
    std::filesystem::copy_file(
        _path, _path + ".old", std::filesystem::copy_options::overwrite_existing, error);
    if (error)
        throw base::InputError("readings \"" + _path + "\" can't be copied to \"" + _path +
                               ".old\": " + error.message());
    std::string text = fmt::format("# plan {}\n", _sum);
    for (int row = 0; row < _plan.size(); ++row)
    {
        if (_plan.rows[static_cast<std::size_t>(row)].place == place)
            _found.values[row] = {std::nan(""), 0.0};
        else if (isRead(row))
            text += lineOf(row, _found.values[row], _found.areLevels);
    }
    // Into a file beside it, which takes its place when it is whole.
    const std::string whole = _path + ".new";
    const int file = ::open(whole.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC, 0644);
    if (file < 0) fail(whole, "opened");
    ::close(_file);
    _file = file;
    if (::flock(_file, LOCK_EX | LOCK_NB) != 0) fail(whole, "locked");
    write(text);
    if (::fdatasync(_file) != 0 || ::rename(whole.c_str(), _path.c_str()) != 0)
        fail(whole, "written");
}

} // namespace midair::samples
