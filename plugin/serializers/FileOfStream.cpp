#include "plugin/serializers/FileOfStream.h"

#include <filesystem>
#include <fstream>
#include <system_error>

namespace osgMidair
{

std::string beginning(std::istream& stream, std::size_t size)
{
    std::streambuf* buffer = stream.rdbuf();
    const auto before = buffer->pubseekoff(0, std::ios::cur, std::ios::in);
    const std::streampos none(std::streamoff(-1));
    if (before == none || buffer->pubseekpos(0, std::ios::in) == none) return {};
    std::string text(size, '\0');
    text.resize(static_cast<std::size_t>(
        buffer->sgetn(text.data(), static_cast<std::streamsize>(text.size()))));
    buffer->pubseekpos(before, std::ios::in);
    return text;
}

std::string wholeText(std::istream& stream)
{
    std::streambuf* buffer = stream.rdbuf();
    const auto before = buffer->pubseekoff(0, std::ios::cur, std::ios::in);
    const auto size = buffer->pubseekoff(0, std::ios::end, std::ios::in);
    const std::streampos none(std::streamoff(-1));
    if (before == none || size == none) return {};
    buffer->pubseekpos(before, std::ios::in);
    return beginning(stream, static_cast<std::size_t>(std::streamoff(size)));
}

// OSG hands serializers an open stream and the folder; Linux says which files are open.
std::string openFile(const std::string& folder, const std::string& text)
{
    namespace fs = std::filesystem;
    std::error_code error;
    const fs::path wanted = fs::weakly_canonical(folder.empty() ? "." : folder, error);
    for (const auto& entry : fs::directory_iterator("/proc/self/fd", error))
    {
        std::error_code none;
        const fs::path file = fs::read_symlink(entry.path(), none);
        if (none || !fs::is_regular_file(file, none)) continue;
        if (fs::weakly_canonical(file.parent_path(), none) != wanted ||
            fs::file_size(file, none) != text.size())
            continue;
        std::ifstream in(file, std::ios::binary);
        if (wholeText(in) == text) return file.filename().string();
    }
    return {};
}

} // namespace osgMidair
