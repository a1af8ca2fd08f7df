//! All words of the pages, in each language, in one table.

/// A language of the pages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Language {
    /// English.
    #[default]
    English,
    /// French.
    French,
    /// Italian.
    Italian,
}

impl Language {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::English, Self::French, Self::Italian];

    /// Its tag, as in BCP 47.
    #[must_use]
    pub fn tag(self) -> &'static str {
        match self {
            Self::English => "en",
            Self::French => "fr",
            Self::Italian => "it",
        }
    }

    /// The first of `tags` that is one of the languages, as in the header `Accept-Language` or a participant's `fr-CH`.
    #[must_use]
    pub fn of(tags: &str) -> Option<Self> {
        tags.split(',').find_map(|tag| {
            let tag = tag
                .split(';')
                .next()
                .unwrap_or_default()
                .trim()
                .to_lowercase();
            let base = tag.split(['-', '_']).next().unwrap_or_default();
            Self::ALL.into_iter().find(|one| one.tag() == base)
        })
    }
}

macro_rules! words {
    ($($(#[$about:meta])* $name:ident: $english:literal, $french:literal, $italian:literal;)*) => {
        /// A word or sentence of the pages.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Word {
            $(
                #[doc = $english]
                $name,
            )*
        }

        impl Word {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$name),*];

            /// It in `language`.
            #[must_use]
            pub fn in_language(self, language: Language) -> &'static str {
                let words = match self {
                    $(Self::$name => [$english, $french, $italian],)*
                };
                words[language as usize]
            }
        }
    };
}

words! {
    Experimenter: "Experimenter", "Expérimentateur", "Sperimentatore";
    ParticipantWord: "Participant", "Participant", "Partecipante";
    Set: "set", "groupe", "gruppo";
    Rehearsal: "rehearsal", "essai à blanc", "prova generale";
    Training: "training", "familiarisation", "familiarizzazione";
    Progress: "Progress", "Avancement", "Avanzamento";
    Trial: "Trial", "Essai", "Prova";
    Of: "of", "sur", "di";
    EventsStored: "Events stored", "Événements enregistrés", "Eventi salvati";
    LastAt: "the last at", "le dernier à", "l'ultimo alle";
    First: "first", "première", "prima";
    Second: "second", "seconde", "seconda";
    Same: "same", "identiques", "uguali";
    Different: "different", "différentes", "diverse";
    DoNotKnow: "I do not know", "Je ne sais pas", "Non lo so";
    StrokesWanted: "Strokes asked for:", "Nombre de passages demandés :", "Passate richieste:";
    StrokesFound: "Strokes found in what was recorded:", "Passages trouvés dans l'enregistrement :", "Passate trovate nella registrazione:";
    NotComplete: "NOT COMPLETE. Strokes found in what was recorded:", "INCOMPLET. Passages trouvés dans l'enregistrement :",
        "NON COMPLETO. Passate trovate nella registrazione:";
    NotRecorded: "THE VIBRATION WAS NOT RECORDED, or not all of it:", "LA VIBRATION N'A PAS ÉTÉ ENREGISTRÉE, ou pas entièrement :",
        "LA VIBRAZIONE NON È STATA REGISTRATA, o non del tutto:";
    NextBegins: "The next one begins by itself in a moment.", "Le suivant commence de lui-même dans un instant.",
        "Il prossimo comincia da solo tra un momento.";
    DraftOf: "On the participant's page:", "Sur la page du participant :", "Sulla pagina del partecipante:";
    AskYourConsent: "Do you consent to take part?", "Consentez-vous à participer ?", "Acconsente a partecipare?";
    EndedWithoutConsent: "The participant did not consent. The session is over, and nothing else was stored.",
        "Le participant n'a pas consenti. La séance est terminée, et rien d'autre n'a été enregistré.",
        "Il partecipante non ha acconsentito. La sessione è terminata, e non è stato salvato altro.";
    ParticipantAway: "The participant's page is not open: the participant cannot stop a texture. Ask, or make a new code.",
        "La page du participant n'est pas ouverte : le participant ne peut pas arrêter une texture. Demandez, ou créez un nouveau code.",
        "La pagina del partecipante non è aperta: il partecipante non può fermare una texture. Chieda, o crei un nuovo codice.";
    SayToStop: "To stop, lift your finger and say so: you may at any time.",
        "Pour arrêter, levez le doigt et dites-le : vous le pouvez à tout moment.",
        "Per fermare, sollevi il dito e lo dica: può farlo in qualsiasi momento.";
    NoDrive: "A texture of this trial has no drive, and nothing was played. End the program, prepare the drive, and give the same command.",
        "Une texture de cet essai n'a pas de signal de commande, et rien n'a été joué. Quittez le programme, préparez le signal et redonnez la même commande.",
        "Una texture di questa prova non ha un segnale di comando, e nulla è stato riprodotto. Termini il programma, prepari il segnale e dia lo stesso comando.";
    IConsent: "I consent", "Je consens", "Acconsento";
    IDoNotConsent: "I do not consent", "Je ne consens pas", "Non acconsento";
    NotTaken: "This was not taken. Look at the page, and try again; if it does not help, tell the experimenter.",
        "Ceci n'a pas été pris en compte. Regardez la page et réessayez ; si cela ne suffit pas, dites-le à l'expérimentateur.",
        "Non è stato accettato. Guardi la pagina e riprovi; se non basta, lo dica allo sperimentatore.";
    ClockBehind: "THE CLOCK OF THE COMPUTER IS BEHIND.", "L'HORLOGE DE L'ORDINATEUR RETARDE.", "L'OROLOGIO DEL COMPUTER È INDIETRO.";
    AskConsent: "Does the participant consent?", "Le participant consent-il ?", "Il partecipante dà il consenso?";
    ConsentInWords: "Ask the participant for consent, in your own words.",
        "Demandez le consentement du participant avec vos propres mots.",
        "Chieda il consenso al partecipante con parole sue.";
    Yes: "Yes", "Oui", "Sì";
    No: "No", "Non", "No";
    Check: "Check:", "Vérifier :", "Verificare:";
    ItIsSo: "It is so", "C'est fait", "È così";
    LayOut: "Lay the samples out, from the left:", "Disposez les échantillons, de gauche à droite :",
        "Disponga i campioni, da sinistra:";
    LaidOut: "They are laid out", "Ils sont en place", "Sono disposti";
    HandOver: "Hand over:", "Donnez :", "Consegni:";
    HandedOver: "Handed over", "Donné", "Consegnato";
    PressAgain: "Press again to confirm", "Appuyez encore pour confirmer", "Prema ancora per confermare";
    AnotherOne: "Another one was handed over", "Un autre a été donné", "È stato consegnato un altro";
    WhichOnes: "Which ones, in their order", "Lesquels, dans l'ordre", "Quali, nell'ordine";
    Note: "Note", "Note", "Nota";
    KeepNote: "Keep the note", "Garder la note", "Conservare la nota";
    Pause: "Pause", "Pause", "Pausa";
    GoOn: "Go on", "Reprendre", "Riprendere";
    InPause: "The session is paused.", "La séance est en pause.", "La sessione è in pausa.";
    Stop: "Stop the session", "Arrêter la séance", "Fermare la sessione";
    Why: "Why", "Pourquoi", "Perché";
    Withdraw: "The participant withdraws", "Le participant se retire", "Il partecipante si ritira";
    TexturesOnDevice: "Textures on the device:", "Textures sur le dispositif :", "Texture sul dispositivo:";
    PlayThem: "Play them", "Les jouer", "Riprodurle";
    PlayByHand: "Play by hand, one after the other:", "Jouez à la main, l'une après l'autre :",
        "Riproduca a mano, una dopo l'altra:";
    Played: "They were played", "Elles ont été jouées", "Sono state riprodotte";
    Playing: "Playing: texture", "Lecture : texture", "Riproduzione: texture";
    StopTexture: "Stop the texture", "Arrêter la texture", "Fermare la texture";
    EscapeKey: "Esc", "Échap", "Esc";
    NeedPause: "I need a pause", "J'ai besoin d'une pause", "Ho bisogno di una pausa";
    OpenTwice: "This page is open twice. Close one of them.", "Cette page est ouverte deux fois. Fermez-en une.",
        "Questa pagina è aperta due volte. Ne chiuda una.";
    Sending: "Being stored …", "Enregistrement en cours …", "Salvataggio in corso …";
    AfterTexture: "Kept on this page; it is stored when the texture has ended.",
        "Gardé sur cette page ; enregistré à la fin de la texture.",
        "Conservato su questa pagina; viene salvato alla fine della texture.";
    Stopping: "Stopping …", "Arrêt en cours …", "Arresto in corso …";
    OwnOrder: "On the tray, in the participant's order:", "Sur le plateau, dans l'ordre du participant :",
        "Sul vassoio, nell'ordine del partecipante:";
    PlayAgain: "Once more", "Encore une fois", "Ancora una volta";
    Felt: "felt", "ressentie", "sentita";
    Texture: "Texture", "Texture", "Texture";
    Choose: "Choose:", "Choisissez :", "Scelga:";
    ChooseForEach: "For each texture, choose:", "Pour chaque texture, choisissez :", "Per ogni texture, scelga:";
    ChooseLetters: "For each texture, in the order in which they were felt, choose a sample of your own order (A is the first):",
        "Pour chaque texture, dans l'ordre où elles ont été ressenties, choisissez un échantillon de votre propre ordre (A est le premier) :",
        "Per ogni texture, nell'ordine in cui sono state sentite, scelga un campione del suo ordine (A è il primo):";
    PutInOrder: "Put them in order, from the first to the last:", "Mettez-les dans l'ordre, du premier au dernier :",
        "Li metta in ordine, dal primo all'ultimo:";
    PutPlacesInOrder: "Put the samples in order. The letters are their places on the tray, from the left:",
        "Mettez les échantillons dans l'ordre. Les lettres sont leurs places sur le plateau, de gauche à droite :",
        "Metta i campioni in ordine. Le lettere sono i loro posti sul vassoio, da sinistra:";
    ChooseUpTo: "Choose up to", "Choisissez au plus", "Scelga al massimo";
    ANumber: "Choose a number:", "Choisissez un nombre :", "Scelga un numero:";
    DoneWord: "Done", "Fait", "Fatto";
    Undo: "Take back", "Retirer", "Togli";
    ThisIsIt: "This is the answer", "C'est la réponse", "Questa è la risposta";
    Noted: "Noted:", "Noté :", "Annotato:";
    Final: "It is final", "C'est définitif", "È definitivo";
    Change: "Change it", "Changer", "Cambiare";
    AllDone: "All trials are done.", "Tous les essais sont faits.", "Tutte le prove sono fatte.";
    EndSession: "End the session", "Terminer la séance", "Terminare la sessione";
    Over: "The session is over. Thank you.", "La séance est terminée. Merci.", "La sessione è terminata. Grazie.";
    StoppedEarly: "The session was stopped before its end. What was answered is stored.",
        "La séance a été arrêtée avant la fin. Les réponses données sont enregistrées.",
        "La sessione è stata fermata prima della fine. Le risposte date sono salvate.";
    Withdrawn: "The participant has withdrawn: erase everything now with piezotact campaign withdraw.",
        "Le participant s'est retiré : effacez tout maintenant avec piezotact campaign withdraw.",
        "Il partecipante si è ritirato: cancelli tutto ora con piezotact campaign withdraw.";
    Wait: "Please wait.", "Veuillez patienter.", "Attenda, per favore.";
    TouchNow: "Touch what is in front of you.", "Touchez ce qui est devant vous.", "Tocchi ciò che ha davanti.";
    Correct: "Correct an answer", "Corriger une réponse", "Correggere una risposta";
    NewAnswer: "The answer as it was said", "La réponse telle qu'elle a été dite", "La risposta come è stata detta";
    KeepCorrection: "Keep the correction", "Garder la correction", "Conservare la correzione";
    Answers: "Answers", "Réponses", "Risposte";
    Log: "What was stored", "Ce qui a été enregistré", "Che cosa è stato salvato";
    LastStimulus: "Last stimulus", "Dernier stimulus", "Ultimo stimolo";
    TargetMet: "target met", "cible atteinte", "obiettivo raggiunto";
    TargetNotMet: "MISSED ITS TARGET", "CIBLE MANQUÉE", "OBIETTIVO MANCATO";
    TargetOpen: "target not decided", "cible non décidée", "obiettivo non deciso";
    ForceWord: "normal force", "force normale", "forza normale";
    Level: "level", "niveau", "livello";
    ParticipantPage: "The participant's page", "La page du participant", "La pagina del partecipante";
    PairingHelp: "Open this address once, on the participant's screen: another window or browser of this computer.",
        "Ouvrez cette adresse une seule fois, sur l'écran du participant : une autre fenêtre ou un autre navigateur de cet ordinateur.",
        "Apra questo indirizzo una sola volta, sullo schermo del partecipante: un'altra finestra o un altro browser di questo computer.";
    NewCode: "Make a new code", "Créer un nouveau code", "Creare un nuovo codice";
    Paired: "A device of the participant is connected.", "Un appareil du participant est connecté.",
        "Un dispositivo del partecipante è collegato.";
    NotPaired: "No device of the participant is connected; the answers that are said aloud are entered here.",
        "Aucun appareil du participant n'est connecté ; les réponses dites à voix haute sont saisies ici.",
        "Nessun dispositivo del partecipante è collegato; le risposte dette a voce si inseriscono qui.";
    PagesOpen: "experimenter pages are open", "pages d'expérimentateur sont ouvertes", "pagine di sperimentatore sono aperte";
    Blind: "What is played is hidden.", "Ce qui est joué est caché.", "Ciò che viene riprodotto è nascosto.";
    ShowPlayed: "Show what is played", "Montrer ce qui est joué", "Mostrare ciò che viene riprodotto";
    HidePlayed: "Hide what is played", "Cacher ce qui est joué", "Nascondere ciò che viene riprodotto";
    Matrix: "Matrices of all answers", "Matrices de toutes les réponses", "Matrici di tutte le risposte";
    AnswersTable: "Answers as a table", "Réponses en tableau", "Risposte in tabella";
    AllTables: "All tables (ZIP)", "Tous les tableaux (ZIP)", "Tutte le tabelle (ZIP)";
    Sessions: "Sessions of the study", "Séances de l'étude", "Sessioni dello studio";
    SessionWord: "Session", "Séance", "Sessione";
    Trials: "Trials", "Essais", "Prove";
    LastEventUtc: "Last event (UTC)", "Dernier événement (UTC)", "Ultimo evento (UTC)";
    SessionReport: "Report of the session (in English)", "Rapport de la séance (en anglais)", "Rapporto della sessione (in inglese)";
    ParticipantsComplete: "participants have completed the session that the campaign is judged by.",
        "participants ont terminé la séance sur laquelle la campagne est jugée.",
        "partecipanti hanno completato la sessione su cui la campagna è giudicata.";
    SimulatedStudy: "Virtual volunteers answered, no person.", "Des volontaires virtuels ont répondu, aucune personne.",
        "Hanno risposto volontari virtuali, nessuna persona.";
    NoSessions: "No session was begun yet.", "Aucune séance n'a encore commencé.", "Nessuna sessione è ancora iniziata.";
    Back: "Back", "Retour", "Indietro";
    NotBegun: "not begun", "pas commencée", "non iniziata";
    WaitsForConsent: "waits for consent", "attend le consentement", "attende il consenso";
    UnderWay: "under way", "en cours", "in corso";
    IsPaused: "in a pause", "en pause", "in pausa";
    WasStopped: "stopped before its end", "arrêtée avant la fin", "fermata prima della fine";
    WithoutConsent: "ended without consent", "terminée sans consentement", "terminata senza consenso";
    IsComplete: "complete", "complète", "completa";
    WithdrawnNotErased: "consent withdrawn, not erased yet", "consentement retiré, pas encore effacée", "consenso ritirato, non ancora cancellata";
    WithdrawnErased: "consent withdrawn, erased", "consentement retiré, effacée", "consenso ritirato, cancellata";
    UnreadablePlan: "its plan cannot be read", "son plan est illisible", "il suo piano non è leggibile";
    NotConnected: "No connection: nothing is stored until it is back. Your last entry is kept and sent again.",
        "Pas de connexion : rien n'est enregistré tant qu'elle n'est pas rétablie. Votre dernière saisie est gardée et renvoyée.",
        "Nessuna connessione: nulla viene salvato finché non torna. L'ultimo inserimento è conservato e inviato di nuovo.";
    NotStored: "NOT STORED. Your entry is kept on this page and is sent again.",
        "NON ENREGISTRÉ. Votre saisie est gardée sur cette page et sera renvoyée.",
        "NON SALVATO. L'inserimento è conservato su questa pagina e viene inviato di nuovo.";
    MovedOn: "The session has moved on meanwhile: look at what is noted, and enter it again where it is missing.",
        "La séance a avancé entre-temps : regardez ce qui est noté, et saisissez à nouveau ce qui manque.",
        "La sessione è andata avanti nel frattempo: guardi che cosa è annotato, e inserisca di nuovo ciò che manca.";
    NotYours: "This page belongs to another session or was replaced by another device. Ask the experimenter for a new code.",
        "Cette page appartient à une autre séance ou a été remplacée par un autre appareil. Demandez un nouveau code à l'expérimentateur.",
        "Questa pagina appartiene a un'altra sessione o è stata sostituita da un altro dispositivo. Chieda un nuovo codice allo sperimentatore.";
    Code: "Code", "Code", "Codice";
    Enter: "Enter", "Entrer", "Entrare";
    EnterCode: "Type the code that the program or the experimenter shows.",
        "Tapez le code que montre le programme ou l'expérimentateur.",
        "Digiti il codice mostrato dal programma o dallo sperimentatore.";
    EnterPassword: "The experimenter enters with the password.", "L'expérimentateur entre avec le mot de passe.",
        "Lo sperimentatore entra con la password.";
    PasswordWord: "Password", "Mot de passe", "Password";
    WrongCode: "This code is not valid (any more). The program shows the experimenter's, the experimenter's page makes the participant's: each of these is valid once, for 15 minutes.",
        "Ce code n'est pas (ou plus) valable. Le programme affiche celui de l'expérimentateur, la page de l'expérimentateur crée ceux du participant : chacun est valable une fois, pendant 15 minutes.",
        "Questo codice non è (più) valido. Il programma mostra quello dello sperimentatore, la pagina dello sperimentatore crea quelli del partecipante: ciascuno è valido una volta, per 15 minuti.";
    WrongPassword: "This is not the password of these pages.", "Ce n'est pas le mot de passe de ces pages.", "Non è la password di queste pagine.";
    Busy: "Many passwords are being tried: try again in a few seconds.", "Beaucoup de mots de passe sont essayés : réessayez dans quelques secondes.",
        "Si stanno provando molte password: riprovi tra qualche secondo.";
    TooMany: "Too many wrong tries: wait a minute.", "Trop d'essais erronés : attendez une minute.",
        "Troppi tentativi errati: attenda un minuto.";
    PairingFromNetwork: "Open this address once on the participant's device, or take a picture of the code with it:",
        "Ouvrez cette adresse une seule fois sur l'appareil du participant, ou photographiez le code avec lui :",
        "Apra questo indirizzo una sola volta sul dispositivo del partecipante, o inquadri il codice con esso:";
    CodeAsPicture: "The address as a QR code", "L'adresse en code QR", "L'indirizzo come codice QR";
    StoppedByParticipant: "the participant stopped it", "le participant l'a arrêtée", "il partecipante l'ha fermata";
    StoppedOnPage: "it was stopped on an experimenter's page", "elle a été arrêtée sur une page d'expérimentateur",
        "è stata fermata su una pagina di sperimentatore";
    NobodyWatched: "no page of the experimenter answered for 3 s while it was played: it was closed, hidden by the system, or lost the network",
        "aucune page de l'expérimentateur n'a répondu pendant 3 s : elle a été fermée, masquée par le système, ou a perdu le réseau",
        "nessuna pagina dello sperimentatore ha risposto per 3 s: è stata chiusa, nascosta dal sistema, o ha perso la rete";
    NotBegunItself: "The trial did not begin by itself:", "L'essai n'a pas commencé de lui-même :", "La prova non è cominciata da sola:";
    Void: "THE TRIAL IS VOID and is presented again:", "L'ESSAI EST NUL et sera présenté à nouveau :",
        "LA PROVA È NULLA e viene presentata di nuovo:";
    KeysHelp: "Keys: arrows move, Enter chooses, Backspace takes back.",
        "Touches : les flèches déplacent, Entrée choisit, Retour arrière annule.",
        "Tasti: le frecce spostano, Invio sceglie, Backspace annulla.";
    Bench: "Bench", "Banc", "Banco";
    Live: "Live", "En direct", "In diretta";
    NothingRuns: "Nothing runs.", "Rien n'est en cours.", "Non è in corso nulla.";
    NoConnection: "No connection to the program: what is shown is old.",
        "Pas de connexion au programme : l'affichage est ancien.",
        "Nessuna connessione al programma: ciò che si vede è vecchio.";
    Vibration: "Vibration", "Vibration", "Vibrazione";
    SpectrumWord: "Spectrum of the last 2 s", "Spectre des 2 dernières s", "Spettro degli ultimi 2 s";
    CoherenceWord: "Coherence until now", "Cohérence jusqu'ici", "Coerenza finora";
    MedianCoherence: "median coherence", "cohérence médiane", "coerenza mediana";
    Acquired: "acquired", "acquis", "acquisito";
    LevelNow: "vibration, rms", "vibration, eff.", "vibrazione, eff.";
    ForceMean: "force, mean of 10 s", "force, moyenne sur 10 s", "forza, media su 10 s";
    ForcePresent: "force now", "force actuelle", "forza attuale";
    TimeLeft: "time left", "temps restant", "tempo rimanente";
    RecordTouch: "Record touch", "Enregistrer le toucher", "Registrare il tatto";
    SampleName: "sample (name)", "échantillon (nom)", "campione (nome)";
    Strokes: "strokes (rejected)", "passages (rejetés)", "passate (scartate)";
    Judged: "windows accepted", "fenêtres acceptées", "finestre accettate";
    StartRun: "Start", "Démarrer", "Avviare";
    StopRun: "Stop, and keep what was acquired", "Arrêter et garder l'acquis", "Fermare e conservare l'acquisito";
    Files: "Files", "Fichiers", "File";
    Characterise: "Characterise the device", "Caractériser le dispositif", "Caratterizzare il dispositivo";
    TouchSample: "Touch a sample (twin)", "Toucher un échantillon (jumeau)", "Toccare un campione (gemello)";
    PlayDrive: "Play a drive", "Jouer un signal de commande", "Riprodurre un segnale di comando";
    Duration: "duration", "durée", "durata";
    Excitation: "drive", "excitation", "eccitazione";
    RepeatsWord: "repeats", "répétitions", "ripetizioni";
    SampleWord: "sample", "échantillon", "campione";
    TouchBenchWord: "touch bench", "banc de toucher", "banco di tocco";
    SpeedWord: "speed", "vitesse", "velocità";
    StrokeCount: "strokes", "passages", "passate";
    AngleWord: "finger angle", "angle du doigt", "angolo del dito";
    DriveFile: "drive file", "fichier de commande", "file di comando";
    Metronome: "Metronome", "Métronome", "Metronomo";
    StrokeEvery: "one stroke every", "un passage toutes les", "una passata ogni";
    MetronomeOn: "Start the metronome", "Démarrer le métronome", "Avviare il metronomo";
    MetronomeOff: "Stop the metronome", "Arrêter le métronome", "Fermare il metronomo";
    ForceTone: "Tone for the force", "Son pour la force", "Suono per la forza";
    ForceLow: "press more", "appuyez plus", "prema di più";
    ForceHigh: "press less", "appuyez moins", "prema di meno";
    ForceGood: "the force is right", "la force est bonne", "la forza è giusta";
    RightAnswer: "The right answer was:", "La bonne réponse était :", "La risposta giusta era:";
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No word is missing in a language, or was left in English by mistake.
    #[test]
    fn every_word_stands_in_every_language() {
        for word in Word::ALL {
            for language in Language::ALL {
                let text = word.in_language(language);
                assert!(!text.trim().is_empty(), "{word:?} in {}", language.tag());
                assert_eq!(text.trim(), text, "{word:?} in {}", language.tag());
            }
            let long = word.in_language(Language::English).len() > 12;
            let same = word.in_language(Language::French) == word.in_language(Language::English);
            assert!(!(long && same), "{word:?} is not translated");
            // One word for a session.
            let french = word.in_language(Language::French).to_lowercase();
            assert!(!french.contains("session"), "{word:?}: séance");
        }
    }

    #[test]
    fn the_first_known_language_is_taken() {
        for (tags, found) in [
            ("fr-CH, fr;q=0.9, en;q=0.8", Some(Language::French)),
            ("ja, it;q=0.5", Some(Language::Italian)),
            ("ja", None),
            ("", None),
            ("EN_us", Some(Language::English)),
        ] {
            assert_eq!(Language::of(tags), found, "{tags}");
        }
    }
}
