#pragma once

#include <memory>
#include <string>

#include <CLI/CLI.hpp>

namespace midair::samples
{

/// Exit codes of all programs, as in samples/guides/README.md.
enum ExitCode
{
    EXIT_DONE = 0,
    EXIT_PROBLEM = 1, ///< it ran, but found a problem or did not do all of it
    EXIT_WRONG = 2,   ///< a wrong option, or input that can't be read
    EXIT_DEVICE = 3   ///< the device can't be opened, or failed
};

/// Writes --help with the range and the default behind an option's text: "--frames INT  frames to
/// play (1 .. 100000; default 30)".
class ToolHelp : public CLI::Formatter
{
public:
    std::string make_option_opts(const CLI::Option* option) const override
    {
        if (option->get_type_size() == 0) return {};
        const std::string all = option->get_type_name();
        const std::string type = all.substr(0, all.find(':'));
        std::string text = type.empty() ? "" : " " + type;
        if (option->get_expected_max() == CLI::detail::expected_max_vector_size)
            text += " ...";
        else if (option->get_expected_min() > 1)
            text += " x " + std::to_string(option->get_expected_min());
        return text;
    }

    std::string make_option_desc(const CLI::Option* option) const override
    {
        std::string notes = valuesOf(*option);
        const auto add = [&notes](const std::string& note)
        { notes += (notes.empty() ? "" : "; ") + note; };
        if (const std::string value = option->get_default_str(); !value.empty())
            add("default " + value);
        if (option->get_required()) add("required");
        if (!option->get_needs().empty()) add("with" + namesOf(option->get_needs()));
        if (!option->get_excludes().empty()) add("not with" + namesOf(option->get_excludes()));
        const std::string text = option->get_description();
        return notes.empty() ? text : text + (text.empty() ? "(" : " (") + notes + ")";
    }

private:
    template<typename Options>
    static std::string namesOf(const Options& options)
    {
        std::string names;
        for (const CLI::Option* option : options)
            names += (names.empty() ? " " : ", ") + option->get_name();
        return names;
    }

    /// "1 .. 100000" or "points, slice, none"; empty where there is none, or where the text of the
    /// option has the range.
    static std::string valuesOf(const CLI::Option& option)
    {
        const std::string type = option.get_type_name();
        if (const std::size_t first = type.find(":{"); first != std::string::npos)
        {
            std::string words;
            for (const char c : type.substr(first + 2, type.find('}', first) - first - 2))
                words += c == ',' ? std::string(", ") : std::string(1, c);
            return words;
        }
        const std::size_t open = type.find(" in [");
        const std::size_t dash = type.find(" - ", open);
        const std::size_t close = type.find(']', open);
        const bool isRange = open != std::string::npos && dash < close;
        if (!isRange || option.get_description().find(" .. ") != std::string::npos) return {};
        return type.substr(open + 5, dash - open - 5) + " .. " +
               type.substr(dash + 3, close - dash - 3);
    }
};

/// Prints what is wrong, or the help that was asked for. Returns EXIT_DONE or EXIT_WRONG.
inline int exitOf(const CLI::App& app, const CLI::ParseError& error)
{
    return app.exit(error) == 0 ? EXIT_DONE : EXIT_WRONG;
}

/// Makes \a app and its commands write --help as ToolHelp does.
inline void useToolHelp(CLI::App& app)
{
    const auto help = std::make_shared<ToolHelp>();
    help->column_width(app.get_formatter()->get_column_width());
    app.formatter(help);
    for (CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
        command->formatter(help);
}

/// Parses the command line. Returns true if the program goes on; otherwise \a status is its exit
/// code.
inline bool parseTool(CLI::App& app, int argc, char** argv, int& status)
{
    useToolHelp(app);
    try
    {
        app.parse(argc, argv);
        return true;
    }
    catch (const CLI::ParseError& error)
    {
        status = exitOf(app, error);
        return false;
    }
}

} // namespace midair::samples
