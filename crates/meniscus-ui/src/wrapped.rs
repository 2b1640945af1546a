//! Text in lines of limited length.

/// Returns the words of `text` in lines of at most `most` characters, but for a word that is longer.
pub(crate) fn wrapped(text: &str, most: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= most => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_hold_all_words_and_no_more_than_they_may() {
        let text = "This model was corrected from the free surface alone.";
        let lines = wrapped(text, 20);
        assert_eq!(lines.join(" "), text);
        assert!(lines.iter().all(|line| line.len() <= 20), "{lines:?}");
        assert_eq!(wrapped("uncommonly", 4), ["uncommonly"]);
        assert!(wrapped("", 20).is_empty());
    }
}
